#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""cornice run with the real programs, on a simulated survey: good, bad and interrupted.

pipeline_test.py PROGRAMS
"""

import glob
import hashlib
import json
import math
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


def write_with_strip(west, east, width_m, target):
    """Copies the LAS 1.4 tile `west` and adds the points of `east` that lie within `width_m` of its
    western end; returns how many."""
    with open(west, "rb") as file:
        west = bytearray(file.read())
    with open(east, "rb") as file:
        east = file.read()
    start, length = struct.unpack_from("<I", east, 96)[0], struct.unpack_from("<H", east, 105)[0]
    x_step, x_zero = struct.unpack_from("<d", east, 131)[0], struct.unpack_from("<d", east, 155)[0]
    count, = struct.unpack_from("<Q", east, 247)
    places = range(start, start + count * length, length)
    xs = [struct.unpack_from("<i", east, at)[0] * x_step + x_zero for at in places]
    end = min(xs) + width_m
    strip = [east[at:at + length] for at, x in zip(places, xs) if x <= end]
    first, = struct.unpack_from("<I", west, 96)
    old, = struct.unpack_from("<Q", west, 247)
    struct.pack_into("<Q", west, 247, old + len(strip))
    # The counts by return, of which the whole file's is the sum: the strip's go to its own returns.
    for record in strip:
        at = 255 + 8 * ((record[14] & 15) - 1)
        struct.pack_into("<Q", west, at, struct.unpack_from("<Q", west, at)[0] + 1)
    struct.pack_into("<d", west, 179, max(struct.unpack_from("<d", west, 179)[0], end))
    for at, least in ((195, max), (203, min), (211, max), (219, min)):
        # Highest and lowest y and z of both.
        struct.pack_into("<d", west, at, least(struct.unpack_from("<d", west, at)[0],
                                               struct.unpack_from("<d", east, at)[0]))
    with open(target, "wb") as file:
        file.write(west[:first + old * length] + b"".join(strip) + west[first + old * length:])
    return len(strip)


def read_las(path):
    """(bytes, start of the points, length of one, positions) of a LAS 1.4 file."""
    with open(path, "rb") as file:
        data = bytearray(file.read())
    start, length = struct.unpack_from("<I", data, 96)[0], struct.unpack_from("<H", data, 105)[0]
    count, = struct.unpack_from("<Q", data, 247)
    steps, zeros = struct.unpack_from("<3d", data, 131), struct.unpack_from("<3d", data, 155)
    positions = [tuple(value * step + zero for value, step, zero in zip(
        struct.unpack_from("<3i", data, at), steps, zeros))
        for at in range(start, start + count * length, length)]
    return data, start, length, positions


def write_with_hole(source, centre, radius_m, target):
    """Copies a LAS 1.4 tile without the points around `centre` in plan; returns how many went."""
    data, start, length, positions = read_las(source)
    kept, gone = [], 0
    for number, position in enumerate(positions):
        record = data[start + number * length:start + (number + 1) * length]
        if math.dist(position[:2], centre) > radius_m:
            kept.append(record)
            continue
        gone += 1
        at = 255 + 8 * ((record[14] & 15) - 1)
        struct.pack_into("<Q", data, at, struct.unpack_from("<Q", data, at)[0] - 1)
    struct.pack_into("<Q", data, 247, len(kept))
    end = start + len(positions) * length
    with open(target, "wb") as file:
        file.write(data[:start] + b"".join(kept) + data[end:])
    return gone


def read_vertices(path):
    """{property: values} of the vertices of a binary PLY, with the origin added to x, y and z."""
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    kinds = {"float": "f", "double": "d", "uchar": "B", "int": "i", "uint": "I", "ushort": "H"}
    names, code, count, origin = [], "<", 0, (0.0, 0.0, 0.0)
    element = ""
    for line in head.decode().splitlines():
        words = line.split()
        if words[:3] == ["comment", "cornice", "origin"]:
            origin = tuple(map(float, words[3:6]))
        if words[0] == "element":
            element = words[1]
            count = int(words[2]) if element == "vertex" else count
        if words[0] == "property" and element == "vertex":
            names.append(words[2])
            code += kinds[words[1]]
    size = struct.calcsize(code)
    columns = dict(zip(names, zip(*struct.iter_unpack(code, body[:count * size]))))
    for axis, shift in zip("xyz", origin):
        columns[axis] = [value + shift for value in columns[axis]]
    return columns


class Pipeline(unittest.TestCase):
    """3 x 2 tiles of 40 m, flown once for all tests."""

    @classmethod
    def setUpClass(cls):
        cls.base = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.base)
        flown = run(program("cornice-simulate"), os.path.join(ROOT, "samples/scenes/pass.yaml"),
                    "-o", os.path.join(cls.base, "survey"), "--product", "lidarhd", "--tiles", "3x2",
                    "--tile-size", "40", "--density", "8", "--truth", "none", "--truth-dem-step", "1")
        if flown.returncode != 0:
            raise RuntimeError(flown.stderr)
        cls.names = sorted(name for name in os.listdir(os.path.join(cls.base, "survey"))
                           if name.endswith(".laz"))
        cls.undisturbed = None

    @classmethod
    def remember(cls, contents):
        """What a run that nothing disturbed has made."""
        cls.undisturbed = contents

    def expect_the_bytes_of_an_undisturbed_run(self):
        made = self.contents()
        if self.undisturbed is None:
            shutil.rmtree(self.output)
            code, text = self.process()
            self.assertEqual(code, 0, text)
            self.remember(self.contents())
        self.assertEqual(len(made), 6)
        self.assertEqual(made, self.undisturbed)

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

    def contents(self):
        contents = {}
        for name in self.meshes():
            with open(os.path.join(self.output, "mesh", name), "rb") as file:
                contents[name] = hashlib.sha256(file.read()).hexdigest()
        return contents

    def expect_seamless(self):
        checked = run(program("cornice-stitch"), "--check",
                      *(os.path.join(self.output, "mesh", name) for name in self.meshes()))
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_makes_one_seamless_mesh_a_comparison_and_a_report(self):
        with open(self.config, "a", encoding="utf-8") as file:
            file.write(f"dem: {{files: ['{self.base}/survey/truth/*.tif']}}\n")
        code, text = self.process()
        self.assertEqual((code, self.errors(text)), (0, []), text)
        self.assertEqual(len(self.meshes()), 6)
        self.expect_seamless()
        self.remember(self.contents())
        with open(os.path.join(self.output, "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertGreaterEqual(page.count("<img "), 7)
        for wanted in ("mesh", "survey.hlod", "dem.hlod", "lines.gpkg", "dem", "compare/index.html"):
            self.assertTrue(os.path.exists(os.path.join(self.output, wanted)), wanted)
        with open(os.path.join(self.output, "reports", "compare", "survey.json"),
                  encoding="utf-8") as file:
            compared = json.load(file)
        # The simulated points have 3 cm of noise; the model has one height a pixel of 1 m.
        self.assertLess(compared["quality"]["vertical_nmad_m"], 0.1)
        self.assertGreater(compared["counts"]["pixels"], 9000)
        self.assertNotIn("could not be drawn", page)
        if "No pictures by cornice-viewer" not in page:
            self.assertEqual(page.count("src='data:image/jpeg"), 4)
            self.assertLess(len(page), 6e6)
        self.expect_no_pictures_of_the_viewer_without_opengl()

    def expect_no_pictures_of_the_viewer_without_opengl(self):
        """And that it is no failure; nothing else is done again."""
        # Mesa's driver alone listens to the others.
        mesa = "/usr/share/glvnd/egl_vendor.d/50_mesa.json"
        done = run(*self.words(), env={**os.environ, "__EGL_VENDOR_LIBRARY_FILENAMES": mesa,
                                       "MESA_GL_VERSION_OVERRIDE": "3.3",
                                       "LIBGL_ALWAYS_SOFTWARE": "1"})
        self.assertEqual((done.returncode, self.errors(done.stderr)), (0, []), done.stderr)
        with open(os.path.join(self.output, "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("No pictures by cornice-viewer: "), 1)
        self.assertNotIn("src='data:image/jpeg", page)

    def test_fills_a_hole_in_the_points_from_an_elevation_model(self):
        flown = os.path.join(self.folder, "flown")
        done = run(program("cornice-simulate"), os.path.join(ROOT, "samples/scenes/pass.yaml"),
                   "-o", flown, "--product", "lidarhd", "--tiles", "2x1", "--tile-size", "40",
                   "--density", "8", "--container", "las", "--truth", "none", "--truth-dem-step",
                   "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        shutil.rmtree(self.tiles)
        os.makedirs(self.tiles)
        west, east = sorted(os.path.join(flown, name) for name in os.listdir(flown)
                            if name.endswith(".las"))
        # On the border of both tiles.
        low_x = min(position[0] for position in read_las(east)[3])
        ys = [position[1] for position in read_las(east)[3]]
        hole, radius = (low_x, 0.5 * (min(ys) + max(ys))), 12.0
        for source in (west, east):
            gone = write_with_hole(source, hole, radius,
                                   os.path.join(self.tiles, os.path.basename(source)))
            self.assertGreater(gone, 500)
        code, text = self.process()
        self.assertEqual((code, self.errors(text)), (0, []), text)
        self.assertEqual(self.ground_in(hole, radius - 3.0), [], "is open without a model")
        with open(self.config, "a", encoding="utf-8") as file:
            file.write("fill-dem: ['flown/truth/*.tif']\n")
        code, text = self.process()
        self.assertEqual((code, self.errors(text)), (0, []), text)
        self.expect_seamless()
        self.expect_filled(hole, radius, west, east)
        code, text = self.process("--dry-run")
        self.assertEqual(code, 0, text)
        for name in os.listdir(os.path.join(flown, "truth")):
            os.utime(os.path.join(flown, "truth", name), (0, 0))
        again = run(*self.words("--dry-run")).stdout
        self.assertIn("solve: 2 of 2", again)
        self.assertNotIn("normals", again)

    def ground_in(self, centre, radius_m):
        """(x, y, z, source) of the mesh's vertices around a place."""
        found = []
        for name in self.meshes():
            columns = read_vertices(os.path.join(self.output, "mesh", name))
            found += [vertex for vertex in zip(*(columns[key] for key in ("x", "y", "z", "source")))
                      if math.dist(vertex[:2], centre) <= radius_m]
        return found

    def expect_filled(self, hole, radius, west, east):
        inside = self.ground_in(hole, radius - 3.0)
        self.assertGreater(len(inside), 20)
        self.assertEqual({vertex[3] for vertex in inside}, {2}, "is marked")
        # Against the points that were taken away, which lie within a metre in plan of each vertex.
        taken = [position for source in (west, east) for position in read_las(source)[3]
                 if math.dist(position[:2], hole) <= radius]
        for x, y, z, _ in inside:
            near = [point[2] for point in taken if math.dist(point[:2], (x, y)) < 1.0]
            self.assertTrue(near)
            self.assertLess(min(abs(height - z) for height in near), 1.0)

    def test_gives_the_same_bytes_with_one_thread_as_with_all(self):
        code, text = self.process("--threads", "1")
        self.assertEqual(code, 0, text)
        self.expect_the_bytes_of_an_undisturbed_run()

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

    def own_processes(self):
        """Ids of the processes that name this test's folder on their command line."""
        found = run("ps", "-eo", "pid,args").stdout.splitlines()
        return [int(line.split()[0]) for line in found if self.folder in line]

    def kill_everything(self):
        """As when a machine goes down; until nothing is left that one of them has just started."""
        while numbers := self.own_processes():
            for number in numbers:
                try:
                    os.kill(number, signal.SIGKILL)
                except ProcessLookupError:
                    pass

    def test_resumes_after_being_killed_to_the_same_bytes(self):
        state = os.path.join(self.output, "state", "solve")
        process = subprocess.Popen(self.words(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, start_new_session=True)
        while process.poll() is None and not glob.glob(os.path.join(state, "*.json")):
            time.sleep(0.01)
        self.assertIsNone(process.poll(), "ended too soon")
        self.kill_everything()
        process.communicate(timeout=900)
        ended = {name: os.path.getmtime(os.path.join(state, name)) for name in os.listdir(state)}
        self.assertTrue(ended)
        code, text = self.process()
        self.assertEqual(code, 0, text)
        for name, when in ended.items():
            self.assertEqual(os.path.getmtime(os.path.join(state, name)), when, "done again")
        left = [name for _, _, names in os.walk(self.output) for name in names
                if ".partial" in name]
        self.assertEqual(left, [])
        self.expect_the_bytes_of_an_undisturbed_run()

    def test_names_a_job_that_was_killed_and_does_it_again(self):
        programs = os.path.join(self.folder, "programs")
        os.makedirs(programs)
        for name in os.listdir(PROGRAMS):
            if name.startswith("cornice-") and name != "cornice-poisson":
                os.symlink(program(name), os.path.join(programs, name))
        # Its first extract is killed, on most machines in the midst of its work.
        poisson = os.path.join(programs, "cornice-poisson")
        with open(poisson, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\n[ \"$1\" = extract ] && mkdir '{self.folder}/killed' 2> /dev/null "
                       f"|| exec '{program('cornice-poisson')}' \"$@\"\n"
                       f"'{program('cornice-poisson')}' \"$@\" &\n"
                       "sleep 0.02\nkill -9 $! $$\n")
        os.chmod(poisson, 0o755)
        code, text = self.process("--programs", programs)
        self.assertEqual(code, 1, text)
        self.assertEqual(len(self.errors(text)), 1, text)
        self.assertIn("extract: was killed (signal 9)", self.errors(text)[0])
        self.assertEqual(len(self.meshes()), 5)
        self.expect_seamless()
        code, text = self.process()
        self.assertEqual(code, 0, text)
        self.expect_the_bytes_of_an_undisturbed_run()

    def test_goes_on_when_a_full_disk_has_room_again(self):
        os.makedirs(self.output)
        size = 12
        mounted = run("mount", "-t", "tmpfs", "-o", f"size={size}m", "tmpfs", self.output)
        if mounted.returncode != 0:
            self.skipTest("a small disk can only be mounted as root: " + mounted.stderr.strip())
        try:
            code, text = self.process()
            self.assertEqual(code, 1)
            self.assertIn("the disk is full; free some space", text)
            half = [name for _, _, names in os.walk(os.path.join(self.output, "points"))
                    for name in names if not name.endswith(".ply")]
            self.assertEqual(half, [])
            run("mount", "-o", "remount,size=500m", self.output)
            code, text = self.process()
            self.assertEqual(code, 0, text)
            made = self.contents()
        finally:
            run("umount", "--lazy", self.output)
        self.assertEqual(len(made), 6)
        if self.undisturbed is not None:
            self.assertEqual(made, self.undisturbed)

    def test_cuts_overlapping_tiles_in_the_middle_of_their_overlap(self):
        flown = run(program("cornice-simulate"), os.path.join(ROOT, "samples/scenes/pass.yaml"),
                    "-o", os.path.join(self.folder, "flown"), "--product", "lidarhd", "--tiles",
                    "2x1", "--tile-size", "40", "--density", "8", "--container", "las", "--truth",
                    "none", "--truth-dem-step", "0")
        self.assertEqual(flown.returncode, 0, flown.stderr)
        folder = os.path.join(self.folder, "flown")
        west, east = sorted(os.path.join(folder, name) for name in os.listdir(folder)
                            if name.endswith(".las"))
        shutil.rmtree(self.tiles)
        os.makedirs(self.tiles)
        shutil.copy(east, self.tiles)
        added = write_with_strip(west, east, 10.0, os.path.join(self.tiles, os.path.basename(west)))
        self.assertGreater(added, 1000)
        code, text = self.process()
        self.assertEqual((code, self.errors(text)), (0, []), text)
        self.assertEqual(len(self.meshes()), 2)
        self.expect_seamless()
        with open(os.path.join(self.output, "report.html"), encoding="utf-8") as file:
            self.assertIn("overlaps other tiles by up to", file.read())

    def test_every_key_of_the_schema_is_an_option_of_its_stage(self):
        with open(os.path.join(ROOT, "config", "config.schema.json"), encoding="utf-8") as file:
            sections = json.load(file)["properties"]
        commands = {"flightlines": [["cornice-flightlines"]], "normals": [["cornice-normals"]],
                    "poisson": [["cornice-poisson", "solve"], ["cornice-poisson", "extract"]],
                    "trim": [["cornice-trim"]], "remesh": [["cornice-remesh"]],
                    "stitch": [["cornice-stitch"]], "hlod": [["cornice-hlod", "build"]],
                    "dem": [["cornice-dem"]], "compare": [["cornice-compare"]]}
        for section, programs in commands.items():
            known = "".join(run(program(words[0]), *words[1:], "--help-all").stdout
                            for words in programs)
            for key, schema in sections[section].get("properties", {}).items():
                if (section, key) in (("normals", "noise"), ("normals", "classes"),
                                      ("dem", "files"), ("hlod", "regions")):
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
