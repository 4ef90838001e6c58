"""A WebSocket client of few lines, which can also misbehave."""
import base64
import os
import select
import socket
import struct
import time
import urllib.parse


def request(url, path="/", method="GET", host=None, headers=(), timeout=10):
    """An HTTP answer: status, headers by lower-case name, body. The connection is closed with it."""
    address = urllib.parse.urlparse(url)
    with socket.create_connection((address.hostname, address.port), timeout) as link:
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host if host is not None else address.netloc}", "Connection: close", *headers, "", ""]
        link.sendall("\r\n".join(lines).encode())
        data = b""
        while part := link.recv(65536):
            data += part
    head, _, body = data.partition(b"\r\n\r\n")
    first, *rest = head.decode("latin-1").split("\r\n")
    pairs = dict((name.lower(), value.strip()) for name, _, value in (line.partition(":") for line in rest))
    return int(first.split()[1]) if len(first.split()) > 1 else 0, pairs, body


class Client:
    """One page: `messages` are those that have come."""

    def __init__(self, url, origin=None, host=None, protocol="chequer", buffer=None):
        address = urllib.parse.urlparse(url)
        self.socket = socket.socket()
        if buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.socket.settimeout(10)
        self.socket.connect((address.hostname, address.port))
        host = host or address.netloc
        lines = ["GET / HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                 f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}", f"Sec-WebSocket-Protocol: {protocol}"]
        if origin != "":
            lines.append(f"Origin: {origin or 'http://' + host}")
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        head = b""
        try:
            while b"\r\n\r\n" not in head:
                part = self.socket.recv(1)
                if not part:
                    break
                head += part
        except ConnectionError:
            pass
        self.is_open = b" 101 " in head.split(b"\r\n")[0]
        self.buffer = b""
        self.messages = []

    def send_raw(self, data):
        self.socket.sendall(data)

    def send(self, payload, opcode=2, final=True, claim=None):
        length = len(payload) if claim is None else claim
        head = bytes([(0x80 if final else 0) | opcode])
        if length < 126:
            head += bytes([0x80 | length])
        elif length < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", length)
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", length)
        mask = os.urandom(4)
        self.socket.sendall(head + mask + bytes(value ^ mask[i % 4] for i, value in enumerate(payload)))

    def wish(self, visible=True, kinds=0x3ff, camera=0xffff, width=640):
        self.send(struct.pack("<BBHIHH4f", 1, int(visible), 0, kinds, camera, width, 0, 0, 0, 0) + bytes(20))

    def read(self, seconds):
        """Takes what comes within that time; False once the connection has ended."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if not select.select([self.socket], [], [], left)[0]:
                return True
            try:
                part = self.socket.recv(1 << 18)
            except (ConnectionError, socket.timeout):
                return False
            if not part:
                return False
            self.take(part)
        return True

    def take(self, part):
        self.buffer += part
        while len(self.buffer) >= 2:
            length, at = self.buffer[1] & 127, 2
            if length == 126:
                if len(self.buffer) < 4:
                    return
                length, at = struct.unpack(">H", self.buffer[2:4])[0], 4
            elif length == 127:
                if len(self.buffer) < 10:
                    return
                length, at = struct.unpack(">Q", self.buffer[2:10])[0], 10
            if len(self.buffer) < at + length:
                return
            if self.buffer[0] & 15 == 2:
                self.messages.append((time.monotonic(), self.buffer[at:at + length]))
            self.buffer = self.buffer[at + length:]

    def close(self):
        self.socket.close()
