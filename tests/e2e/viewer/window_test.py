#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""cornice-viewer in a window on a display of its own (Xvfb), keys and mouse sent by xdotool; and
what it says where it cannot open one.

window_test.py PROGRAMS
"""

import contextlib
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import x11
from display import Display, ground_of, share_changed
from made_files import (pixels_of_png, read_png, write_differences, write_hills, write_photograph)

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


class Base(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.file = cls.hierarchy("hills")

    @classmethod
    def hierarchy(cls, name, **more):
        """Of hills; its path."""
        stem = os.path.join(cls.folder, name)
        write_hills(stem + ".ply", **more)
        built = run(program("cornice-hlod"), "build", stem + ".ply", "-o", stem + ".hlod",
                    "--triangles-per-cell", "2000", "--no-progress")
        if built.returncode != 0:
            raise RuntimeError(built.stderr)
        return stem + ".hlod"


class OnDisplay(Base):
    """A window on a display of its own."""

    def open_window(self, *words, resources="", before=None):
        """before: settings of an earlier start."""
        self.place = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.place)
        if before:
            os.mkdir(os.path.join(self.place, "cornice"))
            with open(os.path.join(self.place, "cornice", "viewer.json"), "w",
                      encoding="utf-8") as file:
                json.dump(before, file)
        self.work = os.path.join(self.place, "work")
        os.mkdir(self.work)
        self.display = Display(self.place)
        self.addCleanup(self.display.close)
        if resources:
            with x11.Connection(self.display.environment["DISPLAY"]) as to:
                to.set_resources(resources)
        home = dict(self.display.environment, HOME=self.place, XDG_CONFIG_HOME=self.place,
                    LIBGL_ALWAYS_SOFTWARE="1")
        self.log = os.path.join(self.place, "log")
        with open(self.log, "w", encoding="utf-8") as log:
            self.viewer = subprocess.Popen(
                [program("cornice-viewer"), *words, "--size", "640x480", "--samples", "1",
                 "--log-level", "debug"], cwd=self.work, env=home, stderr=log)
        self.addCleanup(self.end)
        self.window = until(self.find).split()[0]
        # What is pressed before the window has the focus goes elsewhere.
        until(self.takes_focus)
        self.display.do("mousemove", "--window", self.window, "320", "300")

    def find(self):
        self.assertIsNone(self.viewer.poll(), "the viewer has ended")
        return self.display.do("search", "--onlyvisible", "--name", "Cornice")

    def takes_focus(self):
        self.display.do("windowfocus", self.window)
        return self.display.do("getwindowfocus") == self.window

    def end(self):
        if self.viewer.poll() is None:
            self.viewer.kill()
        self.viewer.wait()

    def rest(self, more_than=0):
        """Waits until it draws no more, after more than so many frames; returns how many."""
        def frames_at_rest():
            with open(self.log, encoding="utf-8") as log:
                said = [line for line in log if "waits after" in line or "draws again" in line]
            drawn = int(said[-1].split()[-2]) if said and "waits" in said[-1] else 0
            return drawn if drawn > more_than else None
        return until(frames_at_rest)

    def processor_s(self):
        """Processor time that the viewer has taken."""
        with open(f"/proc/{self.viewer.pid}/stat", encoding="utf-8") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def idles(self):
        """Whether three seconds pass without a frame, and next to no work."""
        drawn, taken = self.rest(), self.processor_s()
        time.sleep(3)
        return self.rest() == drawn and self.processor_s() - taken < 0.3

    def names(self, ending, start="cornice-2"):
        return sorted(name for name in os.listdir(self.work)
                      if name.startswith(start) and name.endswith(ending))

    def move(self, x, y):
        self.display.do("mousemove", "--window", self.window, str(x), str(y))

    def drag(self, button, *places):
        """With the button down from the first place through the others."""
        self.move(*places[0])
        self.display.do("mousedown", button)
        for place in places[1:]:
            self.move(*place)
        self.display.do("mouseup", button)

    def camera(self):
        return self.take_picture()[1]

    def drop(self, *paths):
        x11.drop(self.display.environment["DISPLAY"], int(self.window), paths, PATIENCE_S)

    def pixel(self, x, y):
        """Red, green and blue on the screen, whose corner is the window's."""
        at = 4 * (y * 900 + x)
        return tuple(reversed(self.display.pixels()[at:at + 3]))

    def look_at(self, x, y, z):
        """Types a place, which is seen from 400 m south and 300 m above it."""
        self.display.do("key", "g")
        self.display.do("type", "--delay", "1", f"{x} {y} {z}")
        self.display.do("key", "Return")
        until(lambda: math.dist(self.camera()["eye"], (x, y - 400, z + 300)) < 1.0)

    def quit(self):
        """Ends the window and returns what it kept."""
        self.display.do("key", "ctrl+q")
        self.assertEqual(self.viewer.wait(PATIENCE_S), 0)
        with open(os.path.join(self.place, "cornice", "viewer.json"), encoding="utf-8") as file:
            return json.load(file)

    def take_picture(self):
        """(path of the picture, camera) that F12 writes."""
        for name in self.names(".png") + self.names(".json"):
            os.remove(os.path.join(self.work, name))
        # Once: a second press would wait in the queue, for a picture of what comes before the next.
        self.display.do("key", "F12")
        camera = os.path.join(self.work, until(lambda: self.names(".json"))[0])

        def whole():
            with contextlib.suppress(ValueError), open(camera, encoding="utf-8") as file:
                return json.load(file)
            return None
        found = until(whole)
        return os.path.join(self.work, self.names(".png")[0]), found

    def settled_screen(self):
        """The screen when two looks at it are alike."""
        seen = [b"", self.display.pixels()]

        def look():
            seen.append(self.display.pixels())
            return share_changed(seen[-2], seen[-1]) < 1e-3
        until(look)
        return seen[-1]

    @contextlib.contextmanager
    def between_two_frames(self):
        """What is sent meanwhile comes at once."""
        self.take_picture()
        self.viewer.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self.viewer.send_signal(signal.SIGCONT)

    def columns_with(self, colours):
        """Columns of the screen that show the colours one over the other, the first at the
        bottom."""
        screen, found = self.display.pixels(), 0
        wanted = [bytes(reversed(colour)) for colour in colours]
        for x in range(400, 900):
            # From the bottom to the top, without the fourth byte.
            column = [screen[at:at + 3] for at in range(4 * (699 * 900 + x), 0, -4 * 900)]
            at = 0
            with contextlib.suppress(ValueError):
                for colour in wanted:
                    at = column.index(colour, at) + 1
                found += 1
        return found


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"),
                     "Xvfb or xdotool is not installed: scripts/setup does that")
class Window(OnDisplay):
    """One window for each test."""

    def setUp(self):
        self.open_window(self.file)

    def test_f12_writes_what_is_seen_with_its_camera(self):
        path, camera = self.take_picture()
        width, height, step, rows = read_png(path)
        self.assertEqual((width, height), (640, 480))
        self.assertEqual(len(rows), height * (1 + step * width))
        self.assertGreater(len(set(rows)), 50, "the picture is of one colour")
        self.assertEqual(len(camera["eye"]), 3)
        self.assertTrue(all(math.isfinite(value) for value in camera["eye"]))
        self.assertAlmostEqual(camera["eye"][0], 2600100, delta=1000)

    def test_draws_nothing_while_nothing_happens_and_at_once_when_something_does(self):
        until(self.idles)
        drawn = self.rest()
        for happens in ("key", "n"), ("mousemove", "--window", self.window, "300", "200"), \
                ("click", "2"), ("windowsize", self.window, "600", "500"), \
                ("windowunmap", self.window, "windowmap", self.window):
            self.display.do(*happens)
            drawn = self.rest(drawn)
            # A window without a frame is black.
            self.assertGreater(share_changed(bytes(4 * 900 * 700), self.display.pixels()), 0.4)

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
        for key in ("F1", "F1", "n"):
            # Once it is written, the key before has had its turn: two of F1 in one slow frame show nothing.
            self.take_picture()
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
        until(lambda: 16 <= self.columns_with(SLOPE_COLOURS) <= 18)

    def test_presses_between_two_slow_frames_all_count(self):
        self.take_picture()
        self.assertEqual(self.columns_with(SLOPE_COLOURS), 0)
        # While it stands still, nothing is drawn; then both come at once.
        self.viewer.send_signal(signal.SIGSTOP)
        self.display.do("key", "n", "n")
        self.viewer.send_signal(signal.SIGCONT)
        until(lambda: self.columns_with(SLOPE_COLOURS) >= 15)

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

    def test_bookmarks_and_the_shading_are_kept(self):
        _, seen = self.take_picture()
        self.display.do("key", "b")
        self.display.do("key", "n")
        kept = self.quit()
        self.assertEqual(kept["shading"], "plain")
        self.assertEqual([mark["file"] for mark in kept["bookmarks"]], [self.file])
        self.assertEqual(kept["bookmarks"][0]["eye"], seen["eye"])

    def test_each_drag_is_undone_and_done_again(self):
        self.look_at(2600100, 1200100, 1500)
        seen = [self.camera()]
        for button in "1", "3", "2":
            # Over the ground in the middle of the window.
            self.drag(button, (320, 240), (340, 235), (360, 230))
            seen.append(self.camera())
        turned, moved, looked = (
            (math.dist(after["eye"], before["eye"]), after["heading_deg"] - before["heading_deg"])
            for before, after in zip(seen, seen[1:]))
        self.assertTrue(turned[0] > 1.0 and abs(turned[1]) > 1.0, "turns around the ground")
        self.assertTrue(looked[0] == 0.0 and abs(looked[1]) > 1.0, "looks around")
        self.assertTrue(moved[0] > 1.0 and moved[1] == 0.0, "moves the ground")
        for key, cameras in ("ctrl+z", seen[-2::-1]), ("ctrl+y", seen[1:]):
            for camera in cameras:
                self.display.do("key", key)
                self.assertEqual(self.camera(), camera)

    def test_a_motion_and_a_press_between_two_frames_are_no_drag(self):
        self.look_at(2600100, 1200100, 1500)
        self.move(330, 250)
        before = self.camera()
        with self.between_two_frames():
            self.move(500, 300)
            self.display.do("mousedown", "2")
        self.assertEqual(self.camera(), before)
        self.display.do("mouseup", "2")

    def test_the_wheel_goes_to_the_cursor_and_home_sees_all(self):
        first = self.camera()
        self.look_at(2600100, 1200100, 1500)
        before = self.camera()
        self.move(330, 250)
        self.display.do("click", "4")
        self.assertLess(self.camera()["eye"][2], before["eye"][2] - 20.0)
        self.display.do("key", "Home")
        self.assertEqual(self.camera(), first)

    def test_space_lands_walks_and_flies_again(self):
        # From beside the ground one lands where the cursor is.
        self.move(400, 250)
        self.camera()
        self.display.do("key", "space")
        landed = self.camera()
        self.assertLess(landed["eye"][2], 1540.0)
        self.assertGreater(landed["pitch_deg"], -20.0)
        self.display.do("keydown", "w")
        until(lambda: math.dist(self.camera()["eye"], landed["eye"]) > 1.0)
        self.display.do("keyup", "w")
        walked = self.camera()
        self.assertLess(walked["eye"][2], 1540.0)
        self.assertEqual(walked["pitch_deg"], landed["pitch_deg"])
        self.display.do("key", "space", "keydown", "e")
        until(lambda: self.camera()["eye"][2] > walked["eye"][2] + 5.0)
        self.display.do("keyup", "e")

    def test_a_path_is_made_saved_and_played(self):
        self.display.do("key", "p")
        first = self.camera()
        self.look_at(2600100, 1200100, 1500)
        last = self.camera()
        self.display.do("key", "p", "shift+p", "shift+p", "Home", "ctrl+p")
        until(lambda: self.camera()["eye"] == last["eye"])
        paths = self.names(".json", "cornice-path")
        self.assertEqual(len(paths), 2, "the second is not written over the first")
        for path in paths:
            with open(os.path.join(self.work, path), encoding="utf-8") as file:
                keys = json.load(file)["keys"]
            self.assertEqual([key["eye"] for key in keys], [first["eye"], last["eye"]])

    def test_pictures_of_one_second_are_all_kept(self):
        self.camera()
        with self.between_two_frames():
            self.display.do("key", "F12", "F12", "F12", "F12")
        until(lambda: len(self.names(".json")) == 5)
        self.assertEqual(len(self.names(".png")), 5)

    def test_lives_on_where_its_folder_is_gone(self):
        self.camera()
        shutil.rmtree(self.work)
        before = self.settled_screen()
        self.display.do("key", "p", "shift+p")
        until(lambda: share_changed(before, self.display.pixels()) > 1e-4)
        before = self.settled_screen()
        self.display.do("key", "F12")
        until(lambda: share_changed(before, self.display.pixels()) > 1e-4)
        self.assertEqual(self.quit()["shading"], "natural")

    def test_full_screen_and_back(self):
        before = self.camera()
        self.display.do("key", "F11")
        until(lambda: read_png(self.take_picture()[0])[:2] == (900, 700))
        self.assertEqual(self.camera(), before)
        self.display.do("key", "F11")
        until(lambda: read_png(self.take_picture()[0])[:2] == (640, 480))
        kept = self.quit()
        self.assertEqual((kept["window_width"], kept["window_height"]), (640, 480))

    def test_any_size_will_do(self):
        for size in (1, 1), (31, 700), (2000, 1200), (640, 480):
            self.display.do("windowsize", self.window, *map(str, size))
            until(lambda size=size: read_png(self.take_picture()[0])[:2] == size)

    def test_text_leaves_no_motion_behind(self):
        self.display.do("key", "g")
        self.display.do("type", "--delay", "1", "wasdqe")
        self.display.do("key", "Escape")
        before = self.camera()
        self.assertEqual(self.camera(), before)
        self.assertEqual(before["eye"][0], 2600100.0)

    def test_what_is_dropped_is_opened_or_named(self):
        other = self.hierarchy("other", crs="EPSG:2154", origin="700000 6600000 1500")
        high = self.hierarchy("high", origin="2600000 1200000 1530")
        tiles = os.path.join(self.folder, "tiles")
        os.makedirs(tiles)
        write_photograph(os.path.join(tiles, "west"), (255, 0, 0), 2600000)
        write_photograph(os.path.join(tiles, "east"), (0, 0, 255), 2600100)
        grid = os.path.join(self.folder, "grid ä.asc")
        write_differences(grid)
        empty = os.path.join(self.folder, "empty")
        os.mkdir(empty)
        text = os.path.join(self.folder, "text.txt")
        with open(text, "w", encoding="utf-8") as file:
            file.write("no raster")
        self.look_at(2600100, 1200100, 1500)
        self.display.do("key", "l")
        self.camera()
        before = self.settled_screen()
        for wrong in text, other, empty, os.path.join(self.folder, "none.hlod"), self.file:
            said = self.settled_screen()
            self.drop(wrong)
            until(lambda said=said: share_changed(said, self.display.pixels()) > 0)
            now = self.settled_screen()
            self.assertLess(share_changed(ground_of(before), ground_of(now)), 1e-3)
        self.drop(high, text)
        until(lambda: share_changed(ground_of(before), ground_of(self.display.pixels())) > 0.05)
        self.drop(os.path.join(tiles, "west.png"), os.path.join(tiles, "east.png"))
        until(lambda: self.pixel(250, 230)[0] > 2 * self.pixel(250, 230)[2])
        until(lambda: self.pixel(390, 230)[2] > 2 * self.pixel(390, 230)[0])
        self.drop(grid)
        until(lambda: self.pixel(250, 230)[2] > 1.2 * self.pixel(250, 230)[0])
        until(lambda: self.pixel(390, 230)[0] > 1.2 * self.pixel(390, 230)[2])
        self.assertEqual(self.quit()["recent"], [high, self.file])

    def test_a_signal_ends_it(self):
        self.viewer.send_signal(signal.SIGTERM)
        self.assertEqual(self.viewer.wait(PATIENCE_S), 128 + signal.SIGTERM)


@unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"),
                     "Xvfb or xdotool is not installed: scripts/setup does that")
class OtherWindows(OnDisplay):
    """Started otherwise."""

    def test_without_a_file_says_what_to_do_and_takes_one(self):
        self.open_window()
        until(self.idles)
        before = self.settled_screen()
        text = os.path.join(self.folder, "note.txt")
        with open(text, "w", encoding="utf-8") as file:
            file.write("no hierarchy")
        self.drop(text)
        until(lambda: share_changed(before, self.display.pixels()) > 0)
        self.drop(self.file)
        self.assertEqual(self.camera()["eye"][0], 2600100.0)
        self.assertEqual(self.quit()["recent"], [self.file])

    def test_a_latest_file_that_is_gone_or_damaged_keeps_nobody_out(self):
        damaged = os.path.join(self.folder, "damaged.hlod")
        with open(damaged, "w", encoding="utf-8") as file:
            file.write("no hierarchy")
        self.open_window(before={"recent": ["/gone.hlod", damaged]})
        self.drop(self.file)
        self.assertEqual(self.camera()["eye"][0], 2600100.0)

    def test_the_swipe_line_is_dragged_and_the_camera_stays(self):
        self.open_window(self.file, self.hierarchy("raised", origin="2600000 1200000 1530"))
        self.look_at(2600100, 1200100, 1500)
        before = self.camera()
        whole = self.settled_screen()
        self.display.do("key", "l", "v")
        until(lambda: share_changed(whole, self.display.pixels()) > 0.03)
        self.settled_screen()
        with self.between_two_frames():
            self.drag("1", (320, 200), (400, 210), (450, 220))
        # Above the panels and beside the handle and the names.
        until(lambda: min(self.pixel(450, 100)) > 250)
        self.assertLess(min(self.pixel(320, 100)), 250)
        self.assertEqual(self.camera(), before)

    def test_comes_to_rest_with_the_picture_of_a_run_without_a_window(self):
        coarse = "--error-pixels", "8"
        self.open_window(self.file, *coarse)
        # A motion that ends anywhere, and a size that asks for other levels.
        self.display.do("keydown", "w")
        start = self.camera()
        until(lambda: math.dist(self.camera()["eye"], start["eye"]) > 20.0)
        self.display.do("keyup", "w")
        self.camera()
        for size in (640, 690), (640, 480), (640, 600):
            drawn = self.rest()
            self.display.do("windowsize", self.window, *map(str, size))
            self.rest(drawn)
            screen = self.display.pixels()
            alone, camera = (os.path.join(self.place, name) for name in ("alone.png", "at.json"))
            with open(camera, "w", encoding="utf-8") as file:
                json.dump(self.camera(), file)
            drawn = run(program("cornice-viewer"), self.file, "--headless", "-o", alone, "--camera",
                        camera, "--size", f"{size[0]}x{size[1]}", "--samples", "1", "--overwrite",
                        *coarse)
            self.assertEqual(drawn.returncode, 0, drawn.stderr)
            # Between the panels, above the cursor.
            for y, row in list(enumerate(pixels_of_png(alone)))[100:290]:
                first = 4 * (900 * y + 320)
                shown = bytes(screen[at + colour] for at in range(first, first + 4 * 280, 4)
                              for colour in (2, 1, 0))
                self.assertEqual(shown, row[3 * 320:3 * 600], f"{size}, row {y}")

    def test_the_path_of_the_command_line_is_played(self):
        path = os.path.join(self.folder, "path.json")
        keys = [{"time_s": time_s, "eye": [2600100, 1199900 + 40 * time_s, 1650], "heading_deg": 0,
                 "pitch_deg": -30, "field_of_view_deg": 45} for time_s in (0, 1)]
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"keys": keys}, file)
        self.open_window(self.file, "--path", path)
        self.camera()
        self.display.do("key", "ctrl+p")
        until(lambda: self.camera()["eye"] == keys[-1]["eye"])

    def test_panels_are_as_large_as_the_display_asks(self):
        self.open_window(self.file, "--shading", "slope", resources="Xft.dpi: 192\n")
        self.camera()
        self.display.do("key", "l", "windowsize", self.window, "900", "700")
        # The bar of the legend is 18 units wide; its edges may be mixed with what is beside them.
        until(lambda: 34 <= self.columns_with(SLOPE_COLOURS) <= 36)


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
