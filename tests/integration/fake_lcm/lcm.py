"""Stands in for the Python module lcm, which Debian does not package: just enough of it over LCM's UDP multicast, for
messages of one datagram."""

import socket
import struct

GROUP, PORT = "239.255.76.67", 7667
SHORT_MESSAGE = 0x4C433032  # "LC02"


class LCM:
    def __init__(self, url=""):
        self._handlers = {}
        self._sequence = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self._socket.bind((GROUP, PORT))
        membership = struct.pack("4s4s", socket.inet_aton(GROUP), socket.inet_aton("127.0.0.1"))
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)

    def subscribe(self, channel, handler):
        self._handlers[channel] = handler

    def publish(self, channel, data):
        self._sequence += 1
        header = struct.pack(">II", SHORT_MESSAGE, self._sequence)
        self._socket.sendto(header + channel.encode() + b"\0" + data, (GROUP, PORT))

    def handle(self):
        datagram = self._socket.recv(65536)
        if struct.unpack_from(">I", datagram)[0] != SHORT_MESSAGE:
            return
        channel, data = datagram[8:].split(b"\0", 1)
        handler = self._handlers.get(channel.decode())
        if handler:
            handler(channel.decode(), data)
