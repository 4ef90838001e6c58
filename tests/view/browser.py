"""A browser without a window, and the programs that a page is fed by. Everything stays in the test's network namespace.

The browser's own polling is done by WebDriver's waits, which end when a condition holds; nothing sleeps for a fixed time.
"""
import base64
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

BIN = pathlib.Path(os.environ["CHEQUER_BIN"])
DATA = pathlib.Path(os.environ["CHEQUER_TEST_DATA"]) / "data"
DEMO = DATA / "demo_swarm"

# chromium does nothing by itself: no updates, no suggestions, no first-run pages; all names resolve to nothing.
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-default-apps",
         "--disable-dev-shm-usage", "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1 , EXCLUDE localhost",
         "--hide-scrollbars"]


def is_there():
    return shutil.which("chromium") and shutil.which("chromedriver")


class Browser:
    """One window. `run` is JavaScript whose value comes back."""

    def __init__(self, width=1280, height=800):
        self.profile = tempfile.mkdtemp(prefix="view-profile-")
        options = Options()
        options.binary_location = shutil.which("chromium")
        for flag in FLAGS + [f"--window-size={width},{height}", f"--user-data-dir={self.profile}"]:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(60)

    def open(self, url):
        self.driver.get(url)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, script, seconds=20, *arguments):
        """Waits until JavaScript gives something true, and gives that."""
        return WebDriverWait(self.driver, seconds, 0.05).until(lambda driver: driver.execute_script(script, *arguments), f"never true: {script}")

    def complaints(self):
        """What the page's own scripts complained of."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] == "SEVERE" and "WebSocket connection" not in entry["message"] and "chrome://" not in entry["message"]]

    def size(self, width, height):
        self.driver.set_window_size(width, height)

    def dark(self, is_dark):
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}]})

    def picture(self, path):
        """What is shown, as a JPEG."""
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "jpeg", "quality": 72})
        path.write_bytes(base64.b64decode(shot["data"]))

    def close(self):
        self.driver.quit()
        shutil.rmtree(self.profile, ignore_errors=True)


class Program:
    def __init__(self, *arguments, first_line=False):
        self.arguments = [str(argument) for argument in arguments]
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(self.arguments, stdout=subprocess.PIPE if first_line else self.log, stderr=self.log, text=True)
        self.line = self.process.stdout.readline().strip() if first_line else ""

    def output(self):
        self.log.seek(0)
        return self.log.read()

    def stop(self, number=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(10)

    def cpu_seconds(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory_kb(self):
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return int(line.split()[1])
        return 0


def config(folder, name="demo", capture="loop = true", recording=DEMO, side=0.12, rest=""):
    """A configuration of chequerd for a recording; its path."""
    path = pathlib.Path(folder) / f"{name}.toml"
    path.write_text(f'''[camera]
name = "{name}"
calibration = "{recording}/camera.toml"
[capture]
path = "{recording}"
{capture}
[[marker]]
size = "6x6"
variant = "secded"
side = {side}
[log]
level = "warning"
{rest}
''')
    return path


def daemon(path):
    return Program(BIN / "chequerd", "--config", path)


def view(*arguments, port=0):
    program = Program(BIN / "chequer", "view", "--port", port, *arguments, first_line=True)
    assert program.line.startswith("http://127.0.0.1:"), program.output()
    return program


def truth(recording=DEMO):
    """Of each frame: the markers by id."""
    lines = [json.loads(line) for line in (recording / "truth.jsonl").read_text().splitlines() if '"markers"' in line]
    return [{marker["id"]: marker for marker in line["markers"]} for line in lines]


def rotate(q, v):
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx]


def true_outline(marker, focal=480, cx=319.5, cy=239.5):
    """Corners of a marker of the demo recording in its picture, clockwise from its top left, pixels."""
    half = marker["side"] / 2
    points = []
    for x, y in ((-half, half), (half, half), (half, -half), (-half, -half)):
        px, py, pz = (a + b for a, b in zip(marker["position"], rotate(marker["orientation"], [x, y, 0])))
        points.append((cx + focal * px / pz, cy + focal * py / pz))
    return points


def distance(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])
