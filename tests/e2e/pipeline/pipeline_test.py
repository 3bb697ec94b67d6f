#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""cornice run with the real programs, on a simulated survey: good, bad and interrupted.

pipeline_test.py PROGRAMS
"""

import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAMS = ""
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))


def run(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=False, timeout=900, **more)


def program(name):
    return os.path.join(PROGRAMS, name)


def write_las(path, points):
    """LAS 1.2 of point format 1 at 1 cm, all ground, one pulse a millisecond."""
    low = [min(p[axis] for p in points) for axis in range(3)]
    high = [max(p[axis] for p in points) for axis in range(3)]
    header = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"test",
                         b"test", 1, 2020, 227, 227, 0, 1, 28, len(points), len(points), 0, 0, 0, 0)
    header += struct.pack("<12d", 0.01, 0.01, 0.01, 0.0, 0.0, 0.0,
                          high[0], low[0], high[1], low[1], high[2], low[2])
    body = b"".join(
        struct.pack("<3iHBBbBHd", *(round(value * 100) for value in point), 100, 0b001001, 2, 3, 0, 1,
                    300000000.0 + 0.001 * number) for number, point in enumerate(points))
    with open(path, "wb") as file:
        file.write(header + body)


class Pipeline(unittest.TestCase):
    """3 x 2 tiles of 40 m, flown once for all tests."""

    @classmethod
    def setUpClass(cls):
        cls.base = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.base)
        flown = run(program("cornice-simulate"), os.path.join(ROOT, "samples/scenes/pass.yaml"),
                    "-o", os.path.join(cls.base, "survey"), "--product", "lidarhd", "--tiles", "3x2",
                    "--tile-size", "40", "--density", "8", "--truth", "none", "--truth-dem-step", "0")
        if flown.returncode != 0:
            raise RuntimeError(flown.stderr)
        cls.names = sorted(name for name in os.listdir(os.path.join(cls.base, "survey"))
                           if name.endswith(".laz"))

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.tiles = os.path.join(self.folder, "tiles")
        os.makedirs(self.tiles)
        for name in self.names:
            shutil.copy(os.path.join(self.base, "survey", name), self.tiles)
        self.output = os.path.join(self.folder, "out")
        self.config = os.path.join(self.folder, "survey.yaml")
        with open(self.config, "w", encoding="utf-8") as file:
            file.write("tiles: [tiles]\noutput: out\nproduct: lidarhd\nhalo-m: 15\n"
                       "step-m: 1\n")

    def tile(self, number):
        return os.path.join(self.tiles, self.names[number])

    def words(self, *more):
        return [program("cornice"), "run", self.config, "--no-progress", *more]

    def process(self, *more):
        done = run(*self.words(*more))
        return done.returncode, done.stderr

    def errors(self, text):
        return [line for line in text.splitlines() if "error: " in line]

    def meshes(self):
        folder = os.path.join(self.output, "mesh")
        return sorted(os.listdir(folder)) if os.path.isdir(folder) else []

    def expect_seamless(self):
        checked = run(program("cornice-stitch"), "--check",
                      *(os.path.join(self.output, "mesh", name) for name in self.meshes()))
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_makes_one_seamless_mesh_and_a_report(self):
        code, text = self.process()
        self.assertEqual((code, self.errors(text)), (0, []), text)
        self.assertEqual(len(self.meshes()), 6)
        self.expect_seamless()
        with open(os.path.join(self.output, "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("<img "), 5)
        self.assertNotIn("could not be drawn", page)

    def test_gives_the_same_bytes_with_one_thread_and_with_two(self):
        results = []
        for threads in ("1", "2"):
            shutil.rmtree(self.output, ignore_errors=True)
            code, text = self.process("--threads", threads)
            self.assertEqual(code, 0, text)
            contents = {}
            for name in self.meshes():
                with open(os.path.join(self.output, "mesh", name), "rb") as file:
                    contents[name] = file.read()
            results.append(contents)
        self.assertEqual(results[0], results[1])

    def test_goes_on_around_damaged_missing_and_tiny_tiles(self):
        # One cut short, one missing from the grid: the others are whole.
        with open(self.tile(1), "r+b") as file:
            file.truncate(os.path.getsize(self.tile(1)) // 2)
        os.remove(self.tile(4))
        code, text = self.process()
        self.assertEqual(code, 1)
        self.assertEqual(len(self.errors(text)), 1, text)
        self.assertIn(self.names[1], self.errors(text)[0])
        self.assertEqual(len(self.meshes()), 4)
        self.expect_seamless()

    def test_refuses_the_tile_of_another_coordinate_system(self):
        swiss = os.path.join(self.folder, "swiss")
        flown = run(program("cornice-simulate"), os.path.join(ROOT, "samples/scenes/pass.yaml"),
                    "-o", swiss, "--product", "swisssurface3d", "--tiles", "1x1", "--tile-size", "40",
                    "--density", "2", "--truth", "none", "--truth-dem-step", "0")
        self.assertEqual(flown.returncode, 0, flown.stderr)
        foreign = next(name for name in os.listdir(swiss) if name.endswith(".laz"))
        named = "swisssurface3d_2019_2746-1234_2056_5728.laz"
        shutil.copy(os.path.join(swiss, foreign), os.path.join(self.tiles, named))
        code, text = self.process("--until", "info")
        self.assertEqual(code, 1)
        self.assertEqual(len(self.errors(text)), 1, text)
        for wanted in (named, "EPSG:2056+5728", "EPSG:2154"):
            self.assertIn(wanted, self.errors(text)[0])

    def test_lives_with_a_tile_of_three_points_and_with_a_tile_given_twice(self):
        with open(self.config, "a", encoding="utf-8") as file:
            file.write("crs: EPSG:2154+5720\n")
        done = run(program("cornice-info"), "--json", self.tile(5))
        box = json.loads(done.stdout)["files"][0]["bounds"]
        os.remove(self.tile(5))
        low = box["min"]
        write_las(os.path.join(self.tiles, "three.las"),
                  [(low[0] + 5 + 10 * i, low[1] + 5 + 9 * (i % 2), low[2] + 5) for i in range(3)])
        shutil.copy(self.tile(0), os.path.join(self.tiles, "twice.laz"))
        code, text = self.process()
        self.assertEqual(code, 1)
        errors = self.errors(text)
        self.assertTrue(any("twice.laz: covers the ground of" in line for line in errors), text)
        self.assertTrue(all("three.las" in line or "twice.laz" in line for line in errors), text)
        self.assertGreaterEqual(len(self.meshes()), 5)
        self.expect_seamless()

    def test_resumes_after_being_killed(self):
        process = subprocess.Popen(self.words(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, start_new_session=True)
        state = os.path.join(self.output, "state", "solve")
        for _ in range(1200):
            time.sleep(0.1)
            if os.path.isdir(state) and os.listdir(state):
                break
        # Everything at once, as when a machine goes down.
        found = run("ps", "-eo", "pid,args").stdout.splitlines()
        mine = [int(line.split()[0]) for line in found if self.folder in line]
        for number in mine:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        process.communicate(timeout=60)
        ended = {name: os.path.getmtime(os.path.join(state, name)) for name in os.listdir(state)}
        self.assertTrue(ended)
        code, text = self.process()
        self.assertEqual(code, 0, text)
        for name, when in ended.items():
            self.assertEqual(os.path.getmtime(os.path.join(state, name)), when, "done again")
        self.assertEqual(len(self.meshes()), 6)
        left = [name for _, _, names in os.walk(self.output) for name in names
                if ".partial" in name]
        self.assertEqual(left, [])

    def test_goes_on_when_a_full_disk_has_room_again(self):
        os.makedirs(self.output)
        size = 12
        mounted = run("mount", "-t", "tmpfs", "-o", f"size={size}m", "tmpfs", self.output)
        if mounted.returncode != 0:
            self.skipTest("a small disk can only be mounted as root: " + mounted.stderr.strip())
        try:
            code, text = self.process()
            self.assertEqual(code, 1)
            self.assertIn("No space left on device", text)
            half = [name for _, _, names in os.walk(os.path.join(self.output, "points"))
                    for name in names if not name.endswith(".ply")]
            self.assertEqual(half, [])
            run("mount", "-o", "remount,size=500m", self.output)
            code, text = self.process()
            self.assertEqual(code, 0, text)
            self.assertEqual(len(self.meshes()), 6)
        finally:
            run("umount", self.output)

    def test_every_key_of_the_schema_is_an_option_of_its_stage(self):
        with open(os.path.join(ROOT, "config", "config.schema.json"), encoding="utf-8") as file:
            sections = json.load(file)["properties"]
        commands = {"flightlines": [["cornice-flightlines"]], "normals": [["cornice-normals"]],
                    "poisson": [["cornice-poisson", "solve"], ["cornice-poisson", "extract"]],
                    "trim": [["cornice-trim"]], "remesh": [["cornice-remesh"]],
                    "stitch": [["cornice-stitch"]]}
        for section, programs in commands.items():
            known = "".join(run(program(words[0]), *words[1:], "--help-all").stdout
                            for words in programs)
            for key, schema in sections[section].get("properties", {}).items():
                if key in ("noise", "classes"):
                    continue
                with self.subTest(f"{section}.{key}"):
                    on_by_default = f"--no-{key} " in known
                    self.assertTrue(f"--{key} " in known or on_by_default)
                    if schema.get("type") == "boolean":
                        continue
                    self.assertFalse(on_by_default)


if __name__ == "__main__":
    PROGRAMS = sys.argv.pop(1)
    unittest.main()
