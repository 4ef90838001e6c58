"""The view's server against those who misbehave: nobody else notices, and its memory stays."""
import resource
import socket
import struct
import tempfile
import time
import unittest
import urllib.parse

from browser import config, daemon, view
from websocket import Client, request

FRAME, STATUS = 1, 6


def count(client, kind):
    return sum(message[0] == kind for _, message in client.messages)


class ServerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.daemon = daemon(config(cls.folder.name))
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 8192), hard))

    @classmethod
    def tearDownClass(cls):
        cls.daemon.stop()
        cls.folder.cleanup()

    def setUp(self):
        self.view = view()
        self.url = self.view.line

    def tearDown(self):
        self.assertIsNone(self.view.process.poll(), self.view.output())
        self.assertEqual(self.view.stop(), 0, self.view.output())

    def page(self, **options):
        client = Client(self.url, **options)
        self.addCleanup(client.close)
        return client

    def watching(self, **options):
        """A page that gets frames."""
        client = self.page(**options)
        self.assertTrue(client.is_open)
        client.wish()
        end = time.monotonic() + 10
        while count(client, FRAME) < 3 and time.monotonic() < end:
            self.assertTrue(client.read(0.1))
        self.assertGreaterEqual(count(client, FRAME), 3)
        client.messages.clear()
        return client

    def assert_goes_on(self, client, seconds=1.5, least=0.75):
        """It gets most of the 20 frames a second, and none much later than the one before."""
        client.messages.clear()
        self.assertTrue(client.read(seconds))
        times = [at for at, message in client.messages if message[0] == FRAME]
        self.assertGreater(len(times), least * 20 * seconds)

    def test_files_are_those_of_the_page(self):
        status, headers, body = request(self.url)
        self.assertEqual(status, 200)
        self.assertIn(b"<!doctype html>", body)
        self.assertIn("default-src 'self'", headers["content-security-policy"])
        self.assertEqual(headers["x-content-type-options"], "nosniff")
        status, headers, body = request(self.url, "/chart.js")
        self.assertEqual((status, len(body)), (200, int(headers["content-length"])))
        for path in ("/../../etc/passwd", "/%2e%2e/server.cpp", "/nothing", "//nothing", "/index.html/", "/" + "a" * 3000):
            self.assertIn(request(self.url, path)[0], (400, 403, 404), path)

    def test_only_get_is_answered(self):
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH"):
            self.assertNotEqual(request(self.url, method=method, headers=("Content-Length: 0",))[0], 200, method)

    def test_other_hosts_names_are_refused(self):
        for host in ("evil.example", "localhost.evil.example", "", "127.0.0.1.evil.example:80"):
            self.assertNotEqual(request(self.url, host=host)[0], 200, host)
        self.assertEqual(request(self.url, host="localhost:1")[0], 200)

    def test_other_origins_are_refused(self):
        for origin in ("http://evil.example", "null", "", self.url.rstrip("/").replace("127.0.0.1", "localhost"), "https" + self.url.rstrip("/")[4:]):
            self.assertFalse(self.page(origin=origin).is_open, origin)
        self.assertFalse(self.page(host="evil.example", origin="http://evil.example").is_open, "a name that points here")
        self.assertTrue(self.page().is_open)

    def test_a_page_that_says_nonsense_is_closed_alone(self):
        good = self.watching()
        nonsense = [lambda bad: bad.send(b"hello"), lambda bad: bad.send(b"\xff" * 48), lambda bad: bad.send(b"{}", opcode=1),
                    lambda bad: bad.send(b"x" * 100_000), lambda bad: bad.send(b"x" * 10, claim=1 << 60),
                    lambda bad: bad.send(b"\x01" + bytes(20), final=False), lambda bad: bad.send(b"", opcode=7),
                    lambda bad: bad.send_raw(b"\x82\x30" + b"unmasked" * 6), lambda bad: bad.send_raw(bytes(range(256)) * 8)]
        for say in nonsense:
            bad = self.page()
            try:
                say(bad)
                # One that claims more than it sends may be waited for; it is given nothing meanwhile.
                bad.read(0.3)
            except ConnectionError:
                pass
            self.assertEqual(count(bad, FRAME), 0)
        self.assert_goes_on(good)

    def test_twenty_pages_one_of_them_frozen(self):
        pages = [self.watching() for _ in range(19)]
        frozen = self.page(buffer=4096)
        frozen.wish()
        before = self.view.memory_kb()
        for page in pages:
            page.messages.clear()
        end = time.monotonic() + 6
        while time.monotonic() < end:
            for page in pages:
                self.assertTrue(page.read(0.005))
        for page in pages:
            times = [at for at, message in page.messages if message[0] == FRAME]
            self.assertGreater(len(times), 0.85 * 20 * 6)
        self.assertLess(self.view.memory_kb() - before, 8000)
        # It skips what it was too slow for: what it reads now, after what was under way, is of now.
        frozen.read(2)
        sequences = [struct.unpack_from("<d", message, 8)[0] for _, message in frozen.messages if message[0] == FRAME]
        newest = max(struct.unpack_from("<d", message, 8)[0] for _, message in pages[0].messages if message[0] == FRAME)
        self.assertGreater(sequences[-1], newest - 20)
        self.assertTrue(any(later - earlier > 20 for earlier, later in zip(sequences, sequences[1:])), "it skipped")

    def test_thousands_of_connections(self):
        good = self.watching()
        before = self.view.memory_kb()
        address = urllib.parse.urlparse(self.url)
        opened = []
        try:
            for i in range(3000):
                link = socket.socket()
                link.setblocking(False)
                opened.append(link)
                try:
                    link.connect((address.hostname, address.port))
                except (BlockingIOError, OSError):
                    pass
                if i % 3 == 0:
                    try:
                        link.send(b"GET / HT")
                    except OSError:
                        pass
                if i % 100 == 0:
                    good.read(0.01)
            self.assert_goes_on(good)
            self.assertLess(self.view.memory_kb() - before, 20_000)
        finally:
            for link in opened:
                link.close()
        # Those that never said what they want are gone by then, and others are let in.
        end = time.monotonic() + 20
        while time.monotonic() < end:
            try:
                if request(self.url, timeout=2)[0] == 200:
                    break
            except OSError:
                pass
        self.assertEqual(request(self.url)[0], 200)

    def test_slow_headers_are_not_waited_for(self):
        address = urllib.parse.urlparse(self.url)
        with socket.create_connection((address.hostname, address.port), 30) as link:
            link.sendall(b"GET / HTTP/1.1\r\nHost: ")
            begin = time.monotonic()
            self.assertEqual(link.recv(100)[:4] or b"", b"")
            self.assertLess(time.monotonic() - begin, 25)
        with socket.create_connection((address.hostname, address.port), 30) as link:
            try:
                link.sendall(b"GET / HTTP/1.1\r\nX: " + b"a" * 1_000_000)
                link.recv(100)
            except ConnectionError:
                pass
        self.assertEqual(request(self.url)[0], 200)

    def test_a_hidden_page_costs_nothing(self):
        page = self.watching()
        page.wish(visible=False)
        page.read(0.5)
        page.messages.clear()
        self.assertTrue(page.read(1.5))
        self.assertEqual(count(page, FRAME), 0)

    def test_is_bound_to_the_loopback(self):
        port = urllib.parse.urlparse(self.url).port
        lines = [line.split() for line in open(f"/proc/{self.view.process.pid}/net/tcp").read().splitlines()[1:]]
        listening = [line[1] for line in lines if line[3] == "0A" and int(line[1].split(":")[1], 16) == port]
        self.assertEqual(listening, [f"0100007F:{port:04X}"])


if __name__ == "__main__":
    unittest.main(verbosity=2, warnings="ignore")
