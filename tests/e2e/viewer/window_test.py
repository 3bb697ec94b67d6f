#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""cornice-viewer in a window on a display of its own (Xvfb), keys and mouse sent by xdotool; and
what it says where it cannot open one.

window_test.py PROGRAMS
"""

import contextlib
import json
import math
import operator
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

PROGRAMS = ""
# Nothing is judged by how long it takes; who waits longer than this waits for what never comes.
PATIENCE_S = 120
# Of the legend of slopes, the flattest first.
SLOPE_COLOURS = [(236, 240, 232), (250, 230, 80), (244, 150, 50), (220, 60, 50), (150, 60, 150),
                 (80, 50, 120), (20, 20, 20)]


def run(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=False, timeout=PATIENCE_S,
                          **more)


def program(name):
    return os.path.join(PROGRAMS, name)


def until(question):
    """Asks until the answer is something, and returns it."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        if answer := question():
            return answer
        time.sleep(0.1)
    raise TimeoutError(question)


def write_hills(path):
    """A PLY mesh of 200 m of hills."""
    side = 101
    vertices = b"".join(
        struct.pack("<3f", 2.0 * column, 2.0 * row,
                    20.0 * math.sin(0.05 * column) * math.cos(0.07 * row)
                    + 2.0 * math.sin(0.9 * column))
        for row in range(side) for column in range(side))
    faces = b"".join(
        struct.pack("<B3iB3i", 3, at, at + 1, at + side + 1, 3, at, at + side + 1, at + side)
        for row in range(side - 1) for at in range(row * side, row * side + side - 1))
    head = ("ply\nformat binary_little_endian 1.0\ncomment cornice origin 2600000 1200000 1500\n"
            f"element vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {2 * (side - 1) ** 2}\nproperty list uchar int vertex_indices\n"
            "end_header\n")
    with open(path, "wb") as file:
        file.write(head.encode() + vertices + faces)


def read_png(path):
    """(width, height, bytes of a pixel, bytes without the filters' undoing) of a PNG."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[-8:-4] != b"IEND":
        raise ValueError(f"{path} is no whole PNG")
    width, height, depth, kind = struct.unpack_from(">IIBB", data, 16)
    packed, at = b"", 8
    while at < len(data):
        length, = struct.unpack_from(">I", data, at)
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += length + 12
    return width, height, depth // 8 * {2: 3, 6: 4}[kind], zlib.decompress(packed)


class Display:
    """An X server without a screen to look at."""

    def __init__(self, folder):
        self.frame = os.path.join(folder, "Xvfb_screen0")
        reading, writing = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", "900x700x24", "-fbdir", folder,
             "-nolisten", "tcp", "-noreset"], pass_fds=[writing], stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise RuntimeError("Xvfb does not start")
        self.environment = dict(os.environ, DISPLAY=":" + number)
        self.environment.pop("WAYLAND_DISPLAY", None)

    def close(self):
        self.server.terminate()
        self.server.wait()

    def do(self, *words):
        return run("xdotool", *words, env=self.environment).stdout.strip()

    def pixels(self):
        """Of the whole screen, as XWD files have them: four bytes each, row by row."""
        with open(self.frame, "rb") as file:
            data = file.read()
        header = struct.unpack_from(">25I", data)
        width, height, line = header[4], header[5], header[12]
        start = header[0] + 12 * header[19]
        return b"".join(data[start + row * line:start + row * line + 4 * width]
                        for row in range(height))


def share_changed(before, after):
    """Of the bytes of two screens, every 13th looked at, those that differ."""
    before, after = before[::13], after[::13]
    return sum(map(operator.ne, before, after)) / len(before)


class Base(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        write_hills(os.path.join(cls.folder, "hills.ply"))
        cls.file = os.path.join(cls.folder, "hills.hlod")
        built = run(program("cornice-hlod"), "build", os.path.join(cls.folder, "hills.ply"), "-o",
                    cls.file, "--triangles-per-cell", "2000", "--no-progress")
        if built.returncode != 0:
            raise RuntimeError(built.stderr)


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"),
                     "Xvfb or xdotool is not installed: scripts/setup does that")
class Window(Base):
    """One window for each test."""

    def setUp(self):
        self.place = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.place)
        self.display = Display(self.place)
        self.addCleanup(self.display.close)
        home = dict(self.display.environment, HOME=self.place, XDG_CONFIG_HOME=self.place,
                    LIBGL_ALWAYS_SOFTWARE="1")
        self.viewer = subprocess.Popen(
            [program("cornice-viewer"), self.file, "--size", "640x480", "--samples", "1"],
            cwd=self.place, env=home, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        self.window = until(self.find).split()[0]
        self.display.do("windowfocus", self.window)
        self.display.do("mousemove", "--window", self.window, "320", "300")
        self.pictures = 0

    def find(self):
        self.assertIsNone(self.viewer.poll(), "the viewer has ended")
        return self.display.do("search", "--onlyvisible", "--name", "Cornice")

    def end(self):
        if self.viewer.poll() is None:
            self.viewer.kill()
        self.viewer.wait()
        self.viewer.stderr.close()

    def names(self, ending):
        return sorted(name for name in os.listdir(self.place)
                      if name.startswith("cornice-2") and name.endswith(ending))

    def take_picture(self):
        """(path of the picture, camera) that F12 writes."""
        for name in self.names(".png") + self.names(".json"):
            os.remove(os.path.join(self.place, name))
        asked = [0]

        def shot():
            # What is pressed before the window has the focus goes elsewhere: ask again.
            if asked[0] % 30 == 0:
                self.display.do("key", "F12")
            asked[0] += 1
            return self.names(".json")
        camera = os.path.join(self.place, until(shot)[0])

        def whole():
            with contextlib.suppress(ValueError), open(camera, encoding="utf-8") as file:
                return json.load(file)
            return None
        found = until(whole)
        return os.path.join(self.place, self.names(".png")[0]), found

    def settled_screen(self):
        """The screen when two looks at it are alike."""
        seen = [b"", self.display.pixels()]

        def look():
            seen.append(self.display.pixels())
            return share_changed(seen[-2], seen[-1]) < 1e-3
        until(look)
        return seen[-1]

    def test_f12_writes_what_is_seen_with_its_camera(self):
        path, camera = self.take_picture()
        width, height, step, rows = read_png(path)
        self.assertEqual((width, height), (640, 480))
        self.assertEqual(len(rows), height * (1 + step * width))
        self.assertGreater(len(set(rows)), 50, "the picture is of one colour")
        self.assertEqual(len(camera["eye"]), 3)
        self.assertTrue(all(math.isfinite(value) for value in camera["eye"]))
        self.assertAlmostEqual(camera["eye"][0], 2600100, delta=1000)

    def test_keys_fly_and_a_drag_turns(self):
        _, first = self.take_picture()

        def moved():
            self.display.do("key", "w")
            eye = self.take_picture()[1]["eye"]
            return math.dist(eye, first["eye"]) > 1e-3
        until(moved)
        _, before = self.take_picture()
        # Over the ground, so that the view turns around it.
        self.display.do("mousemove", "--window", self.window, "320", "300", "mousedown", "1")
        at = [320]

        def turned():
            at[0] = 320 if at[0] > 500 else at[0] + 40
            self.display.do("mousemove", "--window", self.window, str(at[0]), "300")
            heading = self.take_picture()[1]["heading_deg"]
            return abs(heading - before["heading_deg"]) > 1.0
        until(turned)
        self.display.do("mouseup", "1")

    def test_f1_shows_help_and_n_other_colours(self):
        self.take_picture()
        for key in ("F1", "F1", "n"):
            before = self.settled_screen()
            self.display.do("key", key)
            until(lambda: share_changed(before, self.display.pixels()) > 0.03)

    def test_slopes_have_the_legend_of_their_colours(self):
        self.take_picture()
        self.assertEqual(self.columns_with(SLOPE_COLOURS), 0)
        for _ in range(2):
            before = self.settled_screen()
            self.display.do("key", "n")
            until(lambda: share_changed(before, self.display.pixels()) > 0.03)
        until(lambda: self.columns_with(SLOPE_COLOURS) >= 15)

    def test_presses_between_two_slow_frames_all_count(self):
        self.take_picture()
        self.assertEqual(self.columns_with(SLOPE_COLOURS), 0)
        # While it stands still, nothing is drawn; then both come at once.
        self.viewer.send_signal(signal.SIGSTOP)
        self.display.do("key", "n", "n")
        self.viewer.send_signal(signal.SIGCONT)
        until(lambda: self.columns_with(SLOPE_COLOURS) >= 15)

    @contextlib.contextmanager
    def between_two_frames(self):
        """What is sent meanwhile comes at once."""
        self.take_picture()
        self.viewer.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self.viewer.send_signal(signal.SIGCONT)

    def shows_ground(self):
        # What is done to a layer shows in the frame after.
        self.take_picture()
        return len(set(read_png(self.take_picture()[0])[3])) > 50

    def click_on_first_layer(self):
        self.display.do("mousemove", "--window", self.window, "29", "49", "click", "1")

    def test_clicks_between_two_slow_frames_all_count(self):
        # A panel knows its size, and can be clicked, from its third frame on.
        for _ in range(3):
            self.take_picture()
        with self.between_two_frames():
            self.click_on_first_layer()
        self.assertFalse(self.shows_ground(), "one click hides the layer")
        with self.between_two_frames():
            self.click_on_first_layer()
            self.click_on_first_layer()
            self.click_on_first_layer()
        self.assertTrue(self.shows_ground(), "of three the first and the last show it")
        with self.between_two_frames():
            self.click_on_first_layer()
            self.click_on_first_layer()
        self.assertTrue(self.shows_ground(), "two change nothing")

    def test_a_double_click_goes_there_however_slow_frames_are(self):
        _, before = self.take_picture()
        with self.between_two_frames():
            self.display.do("mousemove", "--window", self.window, "320", "300", "click", "1",
                            "click", "1")

        def came_near():
            eye = self.take_picture()[1]["eye"]
            return eye[2] < before["eye"][2] - 50.0
        until(came_near)

    def test_a_place_is_typed_and_gone_to_however_slow_frames_are(self):
        with self.between_two_frames():
            self.display.do("key", "g")
            self.display.do("type", "--delay", "1", "2600055 1200050 15009")
            self.display.do("key", "BackSpace", "Return")

        def arrived():
            eye = self.take_picture()[1]["eye"]
            return math.dist(eye, (2600055, 1200050 - 400, 1500 + 300)) < 1.0
        until(arrived)

    def columns_with(self, colours):
        """Columns of the screen that show the colours one over the other, the first at the
        bottom."""
        screen, found = self.display.pixels(), 0
        height, width = 700, 900
        for x in range(400, width):
            left = list(colours)
            for y in range(height - 1, -1, -1):
                at = 4 * (y * width + x)
                if screen[at:at + 3] == bytes(reversed(left[0])):
                    left.pop(0)
                    if not left:
                        found += 1
                        break
        return found

    def test_bookmarks_and_the_shading_are_kept(self):
        _, seen = self.take_picture()
        self.display.do("key", "b")
        self.display.do("key", "n")
        self.display.do("key", "ctrl+q")
        self.assertEqual(self.viewer.wait(PATIENCE_S), 0)
        with open(os.path.join(self.place, "cornice", "viewer.json"), encoding="utf-8") as file:
            kept = json.load(file)
        self.assertEqual(kept["shading"], "plain")
        self.assertEqual([mark["file"] for mark in kept["bookmarks"]], [self.file])
        self.assertEqual(kept["bookmarks"][0]["eye"], seen["eye"])

    def test_a_signal_ends_it(self):
        self.viewer.send_signal(signal.SIGTERM)
        self.assertEqual(self.viewer.wait(PATIENCE_S), 128 + signal.SIGTERM)


class Refusals(Base):
    """One line for what cannot be."""

    def expect(self, result, code, *parts):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def test_without_a_display_headless_is_named(self):
        environment = {key: value for key, value in os.environ.items()
                       if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self.expect(run(program("cornice-viewer"), self.file, env=environment), 1, "display",
                    "--headless")

    def test_an_older_opengl_is_named(self):
        environment = dict(os.environ, MESA_GL_VERSION_OVERRIDE="3.3", LIBGL_ALWAYS_SOFTWARE="1")
        self.expect(run(program("cornice-viewer"), self.file, "--headless", "-o",
                        os.path.join(self.folder, "x.png"), "--no-progress", env=environment), 1,
                    "OpenGL", "4.5")

    @unittest.skipUnless(shutil.which("Xvfb"), "Xvfb is not installed: scripts/setup does that")
    def test_an_older_opengl_is_named_for_a_window_too(self):
        with tempfile.TemporaryDirectory() as place, \
                contextlib.closing(Display(place)) as display:
            environment = dict(display.environment, MESA_GL_VERSION_OVERRIDE="3.3",
                               LIBGL_ALWAYS_SOFTWARE="1")
            self.expect(run(program("cornice-viewer"), self.file, env=environment), 1, "OpenGL 4.5",
                        "--headless")

    def test_a_file_of_a_newer_version_is_named(self):
        newer = os.path.join(self.folder, "newer.hlod")
        with open(self.file, "rb") as file:
            data = bytearray(file.read())
        data[8] = 99
        with open(newer, "wb") as file:
            file.write(data)
        self.expect(run(program("cornice-viewer"), newer, "--headless", "-o",
                        os.path.join(self.folder, "x.png"), "--no-progress"), 3, "newer.hlod",
                    "version")


if __name__ == "__main__":
    PROGRAMS = os.path.abspath(sys.argv.pop(1))
    unittest.main()
