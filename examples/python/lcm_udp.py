"""LCM's UDP multicast in Python alone, for where the module lcm is not installed: Debian has no package of it. Has what
chequer_client.py uses of that module; memory stays bounded whatever the network brings."""

import os
import re
import socket
import struct
import urllib.parse

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"
SHORT, FRAGMENT = 0x4C433032, 0x4C433033  # "LC02", "LC03"
SHORT_HEADER = struct.Struct(">II")  # which, number of the message
FRAGMENT_HEADER = struct.Struct(">IIIIHH")  # and bytes of the message, place of these, number of the fragment, fragments
MOST_BYTES, MOST_SENDERS = 4 << 20, 16
PIECE = 60000  # bytes of a message in one datagram


class LCM:
    def __init__(self, url=""):
        """Raises ValueError where the URL is not udpm://GROUP:PORT?ttl=N."""
        url = url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
        parts = urllib.parse.urlsplit(url)
        if parts.scheme != "udpm" or not parts.hostname or not parts.port:
            raise ValueError(f"{url}: lcm_udp.py knows udpm://GROUP:PORT?ttl=N alone; the module lcm knows more")
        self._address = parts.hostname, parts.port
        ttl = int(urllib.parse.parse_qs(parts.query).get("ttl", ["0"])[0])
        self._handlers = []
        self._number = 0
        self._pieces = {}  # of the message that each sender is at: (number, bytes missing, message)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, MOST_BYTES)
        self._socket.bind(self._address)
        membership = struct.pack("4s4s", socket.inet_aton(self._address[0]), socket.inet_aton("0.0.0.0"))
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)

    def subscribe(self, channel, handler):
        """handler(channel, data) gets the messages of all channels that the regular expression matches whole."""
        self._handlers.append((re.compile(channel), handler))

    def publish(self, channel, data):
        self._number = (self._number + 1) & 0xFFFFFFFF
        name = channel.encode() + b"\0"
        if len(name) + len(data) <= PIECE:
            self._socket.sendto(SHORT_HEADER.pack(SHORT, self._number) + name + data, self._address)
            return
        count = -(-len(data) // PIECE)
        for i in range(count):
            header = FRAGMENT_HEADER.pack(FRAGMENT, self._number, len(data), i * PIECE, i, count)
            piece = data[i * PIECE : (i + 1) * PIECE]
            self._socket.sendto(header + (name if i == 0 else b"") + piece, self._address)

    def handle(self):
        """Waits for one datagram, and calls the handlers where it completes a message."""
        datagram, sender = self._socket.recvfrom(65536)
        message = self._message_of(datagram, sender)
        if message is None or b"\0" not in message:
            return
        name, data = message.split(b"\0", 1)
        channel = name.decode("utf-8", "replace")
        for pattern, handler in self._handlers:
            if pattern.fullmatch(channel):
                handler(channel, data)

    def _message_of(self, datagram, sender):
        """Channel, zero byte and data; None while some of it is missing."""
        if len(datagram) < SHORT_HEADER.size:
            return None
        magic, number = SHORT_HEADER.unpack_from(datagram)
        if magic == SHORT:
            return datagram[SHORT_HEADER.size :]
        if magic != FRAGMENT or len(datagram) < FRAGMENT_HEADER.size:
            return None
        _, _, size, place, index, _ = FRAGMENT_HEADER.unpack_from(datagram)
        piece = datagram[FRAGMENT_HEADER.size :]
        if index == 0:
            name, _, piece = piece.partition(b"\0")
            if size > MOST_BYTES:
                return None
            self._pieces.pop(sender, None)
            if len(self._pieces) >= MOST_SENDERS:
                self._pieces.pop(next(iter(self._pieces)))
            self._pieces[sender] = [number, size, name, bytearray(size)]
        begun = self._pieces.get(sender)
        if begun is None or begun[0] != number or len(begun[3]) != size or place + len(piece) > size:
            return None  # its beginning was lost
        begun[3][place : place + len(piece)] = piece
        begun[1] -= len(piece)
        if begun[1] > 0:
            return None
        del self._pieces[sender]
        return begun[2] + b"\0" + bytes(begun[3])
