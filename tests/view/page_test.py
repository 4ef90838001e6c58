"""The page in a real browser, fed by a real chequerd: what it draws is where the truth says, and it recovers by itself.

page_test.py [--pictures FOLDER]: also takes a picture of every page into FOLDER.
"""
import argparse
import pathlib
import re
import signal
import sys
import tempfile
import unittest

import browser
from browser import Browser, Program, config, daemon, distance, true_outline, truth, view

pictures = None

COLOURS = """
const detail = chequer.store.cameras[0].detail;
return detail && detail.found && detail.id === arguments[0] && chequer.panel.shownCells && chequer.panel.shownCells.length === 36 ? chequer.panel.shownCells.join('') : null;
"""


def take(window, name):
    if pictures:
        window.picture(pictures / f"view-{name}.jpg")


class PageTest(unittest.TestCase):
    """One browser for all tests; programs for each."""

    @classmethod
    def setUpClass(cls):
        cls.window = Browser()
        cls.folder = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.window.close()
        cls.folder.cleanup()

    def setUp(self):
        self.programs = []
        self.window.size(1280, 800)

    def tearDown(self):
        complaints = self.window.complaints()
        self.window.open("about:blank")
        for program in self.programs:
            program.stop(signal.SIGKILL)
        self.assertEqual(complaints, [])

    def start(self, program):
        self.programs.append(program)
        return program

    def show(self, page="", rest="[tracks]\nenabled = true", capture="loop = true"):
        self.daemon = self.start(daemon(config(self.folder.name, rest=rest, capture=capture)))
        self.view = self.start(view())
        self.window.open(self.view.line + page)

    def test_markers_are_drawn_where_they_are(self):
        self.show("#live?camera=demo")
        self.window.until("const c = chequer.store.cameras[0]; return c?.picture?.frame?.count === 8 && c.about && chequer.live.drawn.length === 8")
        known = truth()
        worst = worst_map = 0
        for _ in range(5):
            before = self.window.run("return chequer.store.cameras[0].picture.sequence")
            self.window.until("const { picture } = chequer.store.cameras[0]; return picture.frame && picture.sequence > arguments[0]", 20, before)
            shot = self.window.run("""
                const app = chequer; app.live.draw();
                const camera = app.store.cameras[0], frame = camera.picture.frame, tile = app.live.tiles.get(0);
                const { ox, oy, scale } = tile.transform;
                return { sequence: frame.sequence, picture: camera.picture.sequence, scale,
                  drawn: app.live.drawn.map(each => ({ id: frame.u[each.i * 36], outline: each.outline, center: [(each.cx - ox) / scale, (each.cy - oy) / scale],
                    pixels: Array.from({ length: 4 }, (_, k) => [(each.outline[2 * k] - ox) / scale, (each.outline[2 * k + 1] - oy) / scale]) })) };""")
            self.assertEqual(shot["sequence"], shot["picture"], "markers are those of the picture they lie on")
            markers = known[int(shot["sequence"]) % len(known)]
            self.assertEqual(sorted(each["id"] for each in shot["drawn"]), sorted(markers))
            for each in shot["drawn"]:
                for drawn, true in zip(each["pixels"], true_outline(markers[each["id"]])):
                    worst = max(worst, distance(drawn, true))
        print(f"outlines: at most {worst:.3f} px from the truth")
        self.assertLess(worst, 2)

    def test_what_is_drawn_is_seen(self):
        """The pixels of the canvas: on each side of each outline lies the colour of its state, dashed where there is a warning."""
        self.show("#live?camera=demo")
        self.window.until("return chequer.live.drawn.length === 8 && chequer.store.cameras[0].picture")
        shares = self.window.run("""
            chequer.live.freeze(); chequer.live.draw();
            const { u } = chequer.store.cameras[0].picture.frame;
            const canvas = chequer.live.tiles.get(0).canvas, context = canvas.getContext('2d'), ratio = canvas.width / canvas.clientWidth;
            return chequer.live.drawn.map(({ i, outline }) => {
              const isWell = u[i * 36 + 3] === 0;
              let hits = 0, all = 0;
              for (let side = 0; side < 4; ++side) for (let i = 1; i < 20; ++i) {
                const [x0, y0, x1, y1] = [0, 1, 2, 3].map(k => outline[(2 * side + k) % 8]);
                const at = [x0 + (x1 - x0) * i / 20, y0 + (y1 - y0) * i / 20].map(value => Math.round(value * ratio));
                const [r, g, b] = context.getImageData(at[0], at[1], 1, 1).data;
                ++all; hits += g > 150 && (isWell ? g > r + 30 : r > g && g > b + 60);
              }
              return { isWell, share: hits / all };
            });""")
        self.assertEqual(len(shares), 8)
        for each in shares:
            self.assertGreater(each["share"], 0.7 if each["isWell"] else 0.4, shares)

    def test_robots_are_on_the_map_where_they_are(self):
        self.show("#arena")
        self.window.until("return chequer.arena.drawn.length === 8 && chequer.store.cameras[0].tracks")
        known = truth()
        worst = 0
        for _ in range(5):
            # A track lags its robot by what the filter smooths; poses are what is measured.
            shot = self.window.run("""
                const camera = chequer.store.cameras[0]; camera.tracks = camera.robots = null; chequer.arena.draw();
                const { frame } = camera;
                return { sequence: frame.sequence, bodies: chequer.arena.drawn.map(each => {
                  const [x, y] = chequer.arena.view.toUnits(each.px, each.py);
                  return { name: each.name, x, y }; }) };""")
            markers = known[int(shot["sequence"]) % len(known)]
            self.assertEqual(sorted(int(each["name"]) for each in shot["bodies"]), sorted(markers))
            for each in shot["bodies"]:
                worst = max(worst, distance((each["x"], each["y"]), markers[int(each["name"])]["position"][:2]))
            before = self.window.run("return chequer.store.cameras[0].frame.sequence")
            self.window.until("return chequer.store.cameras[0].frame.sequence > arguments[0]", 20, before)
        print(f"map: at most {1000 * worst:.2f} mm from the truth")
        self.assertLess(worst, 0.005)
        take(self.window, "arena")

    def test_the_map_of_the_world_shows_robots_and_what_cameras_see(self):
        height = 1.3  # of the camera, which looks straight down
        (pathlib.Path(self.folder.name) / "world.toml").write_text(f"[world]\nposition = [1.0, 0.5, {height}]\norientation = [0, 1, 0, 0]\n")
        self.show("#arena", rest='[world]\nfile = "world.toml"')
        self.window.until("return chequer.arena.drawn.length === 8 && chequer.store.cameras[0].about?.world_from_camera")
        known = truth()
        shot = self.window.run("""
            chequer.arena.draw();
            return { sequence: chequer.store.cameras[0].frame.sequence, bodies: chequer.arena.drawn.map(each => {
              const [x, y] = chequer.arena.view.toUnits(each.px, each.py); return { name: each.name, x, y }; }) };""")
        markers = known[int(shot["sequence"]) % len(known)]
        for each in shot["bodies"]:
            x, y, _ = markers[int(each["name"])]["position"]
            self.assertLess(distance((each["x"], each["y"]), (1.0 + x, 0.5 - y)), 0.005)
        field = self.window.driver.execute_async_script("const done = arguments[arguments.length - 1]; import('/arena.js').then(({ fieldOf }) => done(fieldOf(chequer.store.cameras[0])));")
        xs, ys = [point[0] for point in field], [point[1] for point in field]
        self.assertAlmostEqual(max(xs) - min(xs), height * 640 / 480, delta=1e-3)
        self.assertAlmostEqual(max(ys) - min(ys), height, delta=1e-3)
        self.assertAlmostEqual(max(xs) + min(xs), 2.0, delta=1e-3)

    def test_measures_between_two_clicks(self):
        self.show("#arena")
        self.window.until("return chequer.arena.drawn.length === 8")
        measured, apart = self.window.run("""
            const { arena } = chequer, box = arena.canvas.getBoundingClientRect();
            arena.measure();
            for (const [x, y] of [[100, 120], [400, 520]]) arena.canvas.dispatchEvent(new MouseEvent('click', { clientX: box.x + x, clientY: box.y + y, bubbles: true }));
            arena.draw();
            return [arena.measured, 500 / arena.view.scale];""")
        self.assertAlmostEqual(measured, apart, delta=2 * apart / 500)

    def test_follows_the_system_s_dark_theme(self):
        self.show("#arena")
        ground = "return getComputedStyle(document.body).backgroundColor"
        light = self.window.run(ground)
        self.window.dark(True)
        try:
            self.assertNotEqual(self.window.run(ground), light)
            self.window.until("return chequer.arena.drawn.length === 8")
            pixel = self.window.run("const { context } = { context: chequer.arena.canvas.getContext('2d') }; chequer.arena.draw(); return [...context.getImageData(2, 2, 1, 1).data]")
            self.assertLess(max(pixel[:3]), 80, "the map is dark too")
            self.window.until("return chequer.store.cameras[0].trails.size === 8 && [...chequer.store.cameras[0].trails.values()].every(trail => trail.length > 15)")
            take(self.window, "arena-dark")
        finally:
            self.window.dark(False)

    def test_a_click_shows_the_cells(self):
        self.show("#live?camera=demo")
        self.window.until("return chequer.live.drawn.length === 8 && chequer.store.cameras[0].picture")
        for wanted in (3, 6):
            # What was drawn may be older than the newest frame, which may have its markers in another order.
            self.window.run("""
                chequer.live.draw();
                const frame = chequer.live.frameOf(chequer.store.cameras[0]);
                const each = chequer.live.drawn.find(drawn => frame.u[drawn.i * 36] === arguments[0]);
                const canvas = chequer.live.tiles.get(0).canvas, box = canvas.getBoundingClientRect();
                const at = { clientX: box.x + each.cx, clientY: box.y + each.cy, bubbles: true };
                canvas.dispatchEvent(new MouseEvent('click', at));""", wanted)
            self.assertEqual(self.window.run("return chequer.marker?.id"), str(wanted))
            shown = self.window.until(COLOURS, 20, str(wanted))
            printed = Program(browser.BIN / "chequer", "detect", "--marker", "6x6:secded", "--json", browser.DEMO / "000000.jpg")
            printed.process.wait(20)
            self.assertEqual(shown, self.colours_of(wanted), "as the code of that id has them")
        if pictures:
            self.window.until("return !!chequer.live.pictureOf(chequer.store.cameras[0])")
            self.window.run("chequer.live.draw()")
        take(self.window, "live")

    def colours_of(self, wanted):
        """What chequer itself prints for an id."""
        cells = Program(browser.BIN.parent / "tests" / "view" / "cells", str(wanted))
        self.assertEqual(cells.process.wait(20), 0)
        return cells.output().strip()

    def test_zooming_asks_for_the_part_that_is_seen(self):
        self.show("#live?camera=demo")
        self.window.until("return chequer.live.drawn.length === 8 && chequer.store.cameras[0].picture")
        self.window.run("const view = chequer.live.tiles.get(0).view; view.zoomAt(view.size()[0] / 2, view.size()[1] / 2, 4);")
        region = self.window.until("const zoom = chequer.store.cameras[0].zoom; return zoom && zoom.region")
        self.assertLess(region[2], 640 * 0.5)
        wish = self.window.run("return chequer.link.wish.region")
        for asked, got in zip(wish, region):
            self.assertLess(abs(asked - got), 3)
        self.window.run("chequer.live.reset()")
        self.assertIsNone(self.window.run("return chequer.link.wish.region"))

    def test_a_hidden_page_gets_nothing(self):
        self.show()
        self.window.until("return chequer.store.cameras[0]?.frames > 5")
        self.window.run("chequer.link.tell({ visible: false })")
        # What was under way arrives; then nothing does, while the server's other page goes on.
        other = Browser()
        try:
            other.open(self.view.line)
            other.until("return chequer.store.cameras[0]?.frames > 5")
            self.window.run("window.quiet = chequer.store.cameras[0].frames")
            other.until("window.from ??= chequer.store.cameras[0].frames; return chequer.store.cameras[0].frames > window.from + 20")
            self.assertLessEqual(self.window.run("return chequer.store.cameras[0].frames - window.quiet"), 1)
        finally:
            other.close()
        self.window.run("chequer.link.tell({ visible: true })")
        self.window.until("return chequer.store.cameras[0].frames > window.quiet + 5")

    def notice(self, text, seconds=5):
        return self.window.until("return chequer.store.notices.find(notice => notice.text.includes(arguments[0]))?.text", seconds, text)

    def test_recovers_when_the_daemon_is_started_anew(self):
        self.show()
        self.window.until("return chequer.store.cameras[0]?.frames > 20 && chequer.store.cameras[0].status")
        self.daemon.stop(signal.SIGKILL)
        self.notice("not heard any more", 8)
        self.window.run("window.before = chequer.store.cameras[0].frames")
        self.start(daemon(config(self.folder.name)))
        self.window.until("return chequer.store.cameras[0].frames > window.before + 2", 3)
        self.notice("heard again")
        self.notice("started anew")

    def test_says_that_a_camera_was_lost(self):
        # Several times: on a slow machine, the page comes up after the first.
        faults = ", ".join(f'"vanish {frame} 2s"' for frame in (40, 160, 280, 400, 520, 640))
        self.show(capture=f"loop = true\nfaults = [{faults}]")
        self.notice("camera waiting", 15)
        self.notice("camera running", 15)
        self.window.until("return chequer.store.cameras[0].frames > 60")

    def test_recovers_when_the_view_is_started_anew(self):
        self.show()
        self.window.until("return chequer.store.cameras[0]?.frames > 5")
        port = self.view.line.rstrip("/").rsplit(":", 1)[1]
        self.view.stop(signal.SIGKILL)
        self.notice("does not answer")
        self.start(view(port=port))
        self.window.until("return chequer.store.connected && chequer.store.cameras[0]?.frames > 2", 3)
        self.notice("answers again")
        self.notice("was started anew")

    def test_a_page_from_elsewhere_gets_nothing(self):
        """A blank page: to a browser, another origin."""
        self.show()
        self.window.until("return chequer.store.cameras[0]?.frames > 2")
        # Not by the page itself, whose own rules forbid it to look elsewhere, but by one without such rules.
        self.window.open("about:blank")
        answer = self.window.driver.execute_async_script("""
            const done = arguments[arguments.length - 1], results = [];
            const socket = new WebSocket(arguments[0].replace('http', 'ws'), 'chequer');
            socket.onopen = () => results.push('opened'); socket.onmessage = () => results.push('message');
            socket.onclose = () => fetch(arguments[0]).then(() => results.push('read'), () => results.push('refused')).then(() => done(results));""", self.view.line)
        self.assertEqual(answer, ["refused"])
        self.window.driver.get_log("browser")  # it complained, as it should

    def test_health_and_setup_say_what_to_do(self):
        self.show("#health")
        self.window.until("return document.querySelector('#health .good')?.textContent.includes('all is well')")
        self.window.until("return chequer.store.cameras[0].timeline.length > 3")
        self.assertIn("20", self.window.run("return document.querySelector('#health table').textContent"))
        take(self.window, "health")
        self.window.run("location.hash = '#setup'")
        self.window.until("return [...document.querySelectorAll('#setup .good')].some(item => item.textContent.startsWith('white balance'))")
        self.window.until("return document.querySelector('#setup small')?.textContent.includes('light cells')")
        take(self.window, "setup")

    def test_health_advises_only_where_something_is_wrong(self):
        self.show("#health")
        advice = self.window.run("""
            const status = { camera_state: 'running', drops: {}, publish_rate_hz: 60, markers_mean: 2,
                             detections: { warning_levels_learnt: 118, warning_poor_fit: 60 } };
            return import('/advice.js').then(({ cameraAdvice }) => cameraAdvice(status, false));""")
        self.assertEqual([(level, what[:18]) for level, what, _ in advice], [("warn", "50 % of the marker")])

    def count_drawing(self, page):
        """While 60 frames come: frames of the browser, fields that were cleared in them, and what they made in the document."""
        self.show(page)
        self.window.until("return chequer.store.cameras[0]?.frames > 20 && chequer[chequer.page].drawn.length === 8")
        return self.window.driver.execute_async_script("""
            const done = arguments[arguments.length - 1], { prototype } = CanvasRenderingContext2D;
            const counts = { frames: 0, most: 0, cleared: 0, made: 0, sprites: 0 }, begin = chequer.store.cameras[0].frames;
            const counted = (object, name, count) => { const plain = object[name]; object[name] = function (...all) { count(this); return plain.apply(this, all); }; };
            // Each drawing of a field begins with its ground.
            const shown = new Map();
            counted(prototype, 'fillRect', context => { if (context.canvas.isConnected) shown.set(context.canvas, (shown.get(context.canvas) ?? 0) + 1); });
            counted(document, 'createElement', () => ++counts.made);
            counted(document, 'createTextNode', () => ++counts.made);
            const next = () => {
              ++counts.frames;
              for (const times of shown.values()) { counts.most = Math.max(counts.most, times); counts.cleared += times; }
              shown.clear();
              if (chequer.store.cameras[0].frames < begin + 60) requestAnimationFrame(next); else done({ ...counts, news: chequer.store.cameras[0].frames - begin });
            };
            requestAnimationFrame(next);""")

    def test_draws_once_a_frame_and_makes_nothing_anew(self):
        for page in ("#live", "#arena"):
            counts = self.count_drawing(page)
            self.assertEqual(counts["most"], 1, (page, counts))
            self.assertLessEqual(counts["made"], 40, (page, counts))  # notices and labels that were not seen before
            for program in self.programs:
                program.stop(signal.SIGKILL)

    def test_hidden_views_draw_nothing(self):
        self.show("#arena")
        self.window.until("return chequer.store.cameras[0]?.frames > 2 && chequer.arena.drawn.length === 8")
        self.window.run("window.drawn = 0; window.from = chequer.store.cameras[0].frames; const { live, health, setup } = chequer; for (const view of [live, health, setup]) view.draw = () => { ++window.drawn; };")
        self.window.until("return chequer.store.cameras[0].frames > window.from + 10")
        self.assertEqual(self.window.run("return window.drawn"), 0)

    def render(self, name, *words, size="640x480"):
        folder = pathlib.Path(self.folder.name) / name
        rendered = Program(browser.BIN / "chequer", "render", "--size", size, "--fps", "10", *words, "--out", folder)
        self.assertEqual(rendered.process.wait(200), 0, rendered.output())
        return folder

    def calibration(self, name, recording, camera_toml, what, *words, rest=""):
        """A configuration whose camera plays a recording, and the calibration of it that was begun."""
        path = pathlib.Path(self.folder.name) / f"{name}.toml"
        path.write_text(f'[camera]\nname = "{name}"\ncalibration = "{camera_toml}"\n[capture]\npath = "{recording}"\nloop = true\n'
                        '[[marker]]\nsize = "6x6"\nvariant = "secded"\nside = "60mm"\n' + rest)
        return self.start(Program(browser.BIN / "chequer", "calibrate", what, "--config", path, *words,
                                  "--out", pathlib.Path(self.folder.name) / f"{name}-{what}.toml"))

    def test_setup_shows_how_a_lens_is_calibrated(self):
        sheet = self.render("sheet", "--marker", "6x6:secded:30mm", "--ids", "2028-2047", "--sheet", "--frames", "40")
        self.view = self.start(view())
        self.window.open(self.view.line + "#setup")
        self.window.until("return chequer.store.connected")
        lens = self.calibration("ceiling", sheet, "none.toml", "lens", "--marker", "6x6", "--side", "30mm", "--ids", "2028-2047")
        # While it runs: what it asks for next, coverage, and, as soon as they are fitted, residuals of what there is.
        advice = self.window.until("const c = chequer.store.cameras[0]?.calibration; return c?.state === 'collecting' && c.views > 2 && c.advice", 30)
        self.assertRegex(advice, "hold it|tilt it|not seen|blurred|enough")
        self.window.until("return [...document.querySelectorAll('#setup .calibration:not([hidden]) .advice')].some(each => each.textContent)")
        self.window.until("return chequer.store.cameras[0].calibration.residuals.length > 0 && chequer.setup.cards.get(0).calibration.lines > 0", 60)
        take(self.window, "calibration")
        self.window.until("return chequer.store.cameras[0].calibration.state === 'done'", 60)
        self.assertEqual(lens.process.wait(60), 0, lens.output())
        shown = self.window.until("const card = chequer.setup.cards.get(0).calibration, c = chequer.store.cameras[0].calibration; return card.counts === c.parts && { ...c, lines: card.lines }")
        # The same as the command printed.
        printed = lens.output()
        coverage = [line.split() for line in printed.splitlines() if re.fullmatch(r"([.0-9+] ){11}[.0-9+]", line.strip())][-8:]
        as_text = lambda views: "." if views == 0 else str(views) if views < 10 else "+"
        self.assertEqual([as_text(views) for views in shown["parts"]], [part for line in coverage for part in line])
        rms, points, views = re.search(r"RMS ([0-9.]+) px over ([0-9]+) points of ([0-9]+) views", printed).groups()
        self.assertAlmostEqual(shown["rms"], float(rms), delta=6e-4)
        self.assertEqual(shown["lines"], len(range(0, int(points), int(points) // 800 + 1)))
        self.assertIn(f"{shown['views']} of ", printed)
        self.assertIn("is calibrated", self.notice("is calibrated"))

    def test_setup_shows_how_the_world_is_calibrated(self):
        folder = pathlib.Path(self.folder.name)
        references = folder / "room.toml"
        references.write_text("".join(f"[[reference]]\nid = {id}\nposition = [{at}]\n" for id, at in ((8, "0, 0"), (9, "1.2, 0"), (10, "0, 1"), (99, "1, 1"))))
        room = self.render("room", "--marker", "6x6:secded:60mm", "--ids", "0-10", "--room", self.three(references), "--distance", "2", "--frames", "20", "--speed", "0",
                           size="1280x960")
        self.view = self.start(view())
        self.window.open(self.view.line + "#setup")
        self.window.until("return chequer.store.connected")
        world = self.calibration("north", room, room / "camera.toml", "world", references)
        seen = self.window.until("const c = chequer.store.cameras[0]?.calibration; return c && c.state !== 'done' && c.rms > 0 && c.references", 30)
        self.assertEqual([each["id"] for each in seen], ["8", "9", "10", "99"])
        self.assertTrue(all(each["frames"] > 0 and each["offset_m"] for each in seen[:3]))
        self.assertEqual((seen[3]["frames"], seen[3]["offset_m"]), (0, None))
        self.window.until("return document.querySelector('#setup .calibration table')?.textContent.includes('not seen')")
        self.window.until("return chequer.store.cameras[0].calibration.state === 'done'", 60)
        self.assertEqual(world.process.wait(60), 0, world.output())
        rms = float(re.search(r"RMS ([0-9.]+) mm", world.output()).group(1))
        self.assertAlmostEqual(1000 * self.window.run("return chequer.store.cameras[0].calibration.rms"), rms, delta=6e-3)

    def three(self, references):
        """The same list without its last, which no marker of the room stands for."""
        path = references.with_name("three.toml")
        path.write_text("[[reference]]".join(references.read_text().split("[[reference]]")[:4]))
        return path

    def test_a_calibration_is_quiet_where_looking_is_forbidden(self):
        sheet = self.render("quiet-sheet", "--marker", "6x6:secded:30mm", "--ids", "2028-2047", "--sheet", "--frames", "10")
        self.view = self.start(view())
        self.window.open(self.view.line + "#setup")
        self.window.until("return chequer.store.connected")
        forbidden = self.calibration("forbidden", sheet, "none.toml", "lens", "--marker", "6x6", "--side", "30mm", "--ids", "2028-2047",
                                     "--seconds", "4", rest="[view]\nallow = false\n")
        forbidden.process.wait(60)
        self.assertIn("frames taken", forbidden.output())
        self.assertEqual(self.window.run("return chequer.store.cameras.map(camera => camera.prefix)"), [])

    def test_pictures_can_be_forbidden(self):
        self.show(rest="[view]\nallow = false")
        self.window.until("return chequer.store.cameras[0]?.frames > 20 && chequer.live.drawn.length === 8")
        self.assertFalse(self.window.run("return !!chequer.store.cameras[0].picture"))

    def test_is_readable_on_a_phone(self):
        self.show()
        self.window.size(400, 800)
        self.window.until("return chequer.live.drawn.length === 8")
        for page in ("live", "arena", "health", "setup"):
            self.window.run("location.hash = '#' + arguments[0]", page)
            self.window.until("return chequer.page === arguments[0]", 5, page)
            self.assertLessEqual(self.window.run("return document.documentElement.scrollWidth - document.documentElement.clientWidth"), 0, page)
        self.window.run("location.hash = '#live'")
        self.window.until("return !!chequer.live.pictureOf(chequer.store.cameras[0])")
        take(self.window, "phone")

    def test_works_by_keyboard(self):
        self.show()
        self.window.until("return chequer.live.drawn.length === 8")
        press = "document.dispatchEvent(new KeyboardEvent('keydown', { key: arguments[0], bubbles: true }))"
        for key, page in (("2", "arena"), ("3", "health"), ("4", "setup"), ("1", "live")):
            self.window.run(press, key)
            self.window.until("return chequer.page === arguments[0]", 5, page)
        self.window.run(press, "f")
        self.assertTrue(self.window.run("return !!chequer.live.frozen"))
        frozen = self.window.run("return chequer.live.frameOf(chequer.store.cameras[0]).sequence")
        self.window.until("return chequer.store.cameras[0].frame.sequence > arguments[0] + 5", 20, frozen)
        self.assertEqual(self.window.run("return chequer.live.frameOf(chequer.store.cameras[0]).sequence"), frozen)

    def test_replays_a_log(self):
        folder = pathlib.Path(self.folder.name)
        log = folder / "run.lcm"
        logger = self.start(Program("lcm-logger", "-q", log))
        live = self.start(view())
        self.daemon = self.start(daemon(config(folder)))
        self.window.open(live.line)  # so that pictures are in the log
        self.window.until("return chequer.store.cameras[0]?.frames > 100 && chequer.store.cameras[0].picture", 30)
        self.window.open("about:blank")
        self.daemon.stop()
        logger.stop(signal.SIGINT)
        replay = self.start(view("--log", log))
        self.window.open(replay.line)
        self.window.until("return !document.getElementById('replay').hidden && chequer.store.cameras[0]?.picture?.frame?.count === 8", 30)
        span = self.window.run("const r = chequer.store.server.replay; return [r.first_ms, r.last_ms]")
        moment = span[0] + 0.6 * (span[1] - span[0])
        # A link to a moment shows the same in any window.
        shown = []
        for _ in range(2):
            self.window.open("about:blank")
            self.window.open(f"{replay.line}#live?t={int(moment)}")
            self.window.until("return chequer.store.server?.replay?.playing === false && chequer.store.cameras[0]?.frame && chequer.store.cameras[0].picture")
            shown.append(self.window.run("return chequer.store.cameras[0].frame.sequence"))
        self.assertEqual(shown[0], shown[1])
        self.assertLess(abs(self.window.run("return chequer.store.server.replay.now_ms") - moment), 50)
        take(self.window, "replay")
        self.window.run("chequer.replay.toggle()")
        self.window.until("return chequer.store.cameras[0]?.frame?.sequence > arguments[0]", 10, shown[0])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--pictures", type=pathlib.Path)
    options, rest = parser.parse_known_args()
    if not browser.is_there():
        print("chromium and chromedriver are not here: scripts/setup installs them")
        sys.exit(77)
    pictures = options.pictures
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore")
