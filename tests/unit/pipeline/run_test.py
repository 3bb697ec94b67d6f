#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a survey's run goes on, stops and resumes. Programs are stood in for; Snakemake is real."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
RUN = os.path.join(ROOT, "pipeline", "scripts", "run.py")
PROGRAMS = ("index", "info", "flightlines", "normals", "poisson", "trim", "remesh", "stitch",
            "hlod", "dem", "compare", "picture")


class Survey(unittest.TestCase):
    """Three tiles in a row: a, b, c."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        programs = os.path.join(self.folder, "programs")
        os.makedirs(programs)
        for name in PROGRAMS:
            os.symlink(os.path.join(HERE, "fake_program.py"),
                       os.path.join(programs, "cornice-" + name))
        self.runs = os.path.join(self.folder, "runs")
        self.environment = {**os.environ, "RUNS": self.runs}
        self.words = [sys.executable, "-B", RUN, "--programs", programs,
                      os.path.join(self.folder, "survey.yaml")]
        for name in "abc":
            self.write(name + ".laz", "")
        self.configure("")

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="utf-8") as file:
            file.write(text)

    def configure(self, more):
        self.write("survey.yaml", f"tiles: ['*.laz']\noutput: out\n{more}")

    def start(self, *more):
        self.write("runs", "")
        return subprocess.Popen(self.words + list(more), text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, env=self.environment)

    def run_it(self, *more):
        """(exit code, messages, jobs that ran)"""
        process = self.start(*more)
        out, err = process.communicate(timeout=800)
        with open(self.runs, encoding="utf-8") as file:
            jobs = [line.strip() for line in file if not line.startswith("picture")]
        return process.returncode, out + err, jobs

    def wait_for(self, process, text):
        """Returns when `text` stands in the list of runs, however long the machine takes for it."""
        while process.poll() is None:
            with open(self.runs, encoding="utf-8") as file:
                if text in file.read():
                    return
            time.sleep(0.05)
        self.fail("ended too soon: " + process.communicate()[1])

    def result(self, *parts):
        with open(os.path.join(self.folder, "out", *parts), encoding="utf-8") as file:
            return file.read()

    def test_runs_every_job_once_and_then_nothing(self):
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertEqual(len(jobs), 6 * 3 + 3)
        self.assertEqual(len(set(jobs)), len(jobs))
        self.assertIn("report: ", text)
        self.assertIn("What ran", self.result("report.html"))
        self.assertEqual(self.run_it()[2], [])
        code, text, jobs = self.run_it("--dry-run")
        self.assertEqual((code, jobs), (0, []))
        self.assertIn("nothing to do", text)

    def test_a_changed_parameter_redoes_its_stage_and_what_follows(self):
        self.run_it()
        self.configure("trim: {bridge: 7}\n")
        _, _, jobs = self.run_it()
        self.assertEqual({job.split()[0] for job in jobs}, {"trim", "remesh", "stitch", "hlod"})

    def test_a_changed_tile_redoes_itself_and_its_neighbourhood(self):
        self.run_it()
        self.write("a.laz", "changed")
        _, _, jobs = self.run_it()
        self.assertIn("info a", jobs)
        self.assertNotIn("info b", jobs)
        self.assertIn("normals b", jobs)

    def test_a_lost_file_is_made_again(self):
        self.run_it()
        os.remove(os.path.join(self.folder, "out", "trimmed", "b.ply"))
        _, _, jobs = self.run_it()
        self.assertEqual(jobs, ["trim b", "remesh b", "stitch a", "hlod a"])

    def test_one_bad_tile_does_not_stop_the_others(self):
        self.write("b.laz", "fail normals")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 1)
        self.assertIn("b.laz: normals: ", text)
        self.assertIn("is bad as told", text)
        self.assertEqual(text.count("error: "), 1, text)
        self.assertNotIn("solve b", jobs)
        self.assertIn("stitch a", jobs)
        self.assertEqual(sorted(os.listdir(os.path.join(self.folder, "out", "mesh"))),
                         ["a.ply", "c.ply"])
        self.assertIn("is bad as told", self.result("report.html"))

    def test_names_the_classes_of_a_tile_of_which_no_points_are_left(self):
        self.write("b.laz", "classes normals, fail solve")
        code, text, _ = self.run_it()
        self.assertEqual(code, 1)
        self.assertIn("b.laz: solve: no points are left: there are 5 of class 1 (log: ", text)

    def test_the_same_bad_input_is_not_tried_again(self):
        self.write("b.laz", "fail extract")
        self.run_it()
        code, text, jobs = self.run_it()
        self.assertEqual((code, jobs), (1, []), text)
        self.assertIn("b.laz: extract: ", text)

    def test_what_was_killed_is_tried_again_with_what_depends_on_it(self):
        self.write("b.laz", "kill remesh")
        self.run_it()
        code, text, jobs = self.run_it()
        self.assertEqual((code, jobs), (1, ["remesh b", "stitch a", "hlod a"]), text)

    def test_a_moved_survey_holds(self):
        self.run_it()
        os.makedirs(os.path.join(self.folder, "elsewhere"))
        for name in ("out", "a.laz", "b.laz", "c.laz", "survey.yaml"):
            os.rename(os.path.join(self.folder, name), os.path.join(self.folder, "elsewhere", name))
        self.words[-1] = os.path.join(self.folder, "elsewhere", "survey.yaml")
        code, text, jobs = self.run_it()
        self.assertEqual((code, jobs), (0, []), text)

    def test_an_older_file_in_a_tiles_place_counts_as_changed(self):
        self.run_it()
        self.write("a.laz", "older")
        os.utime(os.path.join(self.folder, "a.laz"), (1e9, 1e9))
        self.assertIn("info a", self.run_it()[2])

    def test_a_mended_tile_joins_the_others_without_redoing_what_is_right(self):
        self.write("b.laz", "fail extract")
        self.run_it()
        # The wish travels with the points, so the tile itself has to change.
        self.write("b.laz", "")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertIn("extract b", jobs)
        self.assertNotIn("info a", jobs)
        self.assertEqual(len(os.listdir(os.path.join(self.folder, "out", "mesh"))), 3)

    def test_a_tile_that_cannot_be_opened_is_left_out_and_named(self):
        self.write("b.laz", "unusable")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 1)
        self.assertIn("cornice-run: 2 tiles, 2,000 points, EPSG:2154: 15 jobs to do", text)
        warned = text.index("b.laz: is unusable; the other tiles go on without it")
        self.assertLess(warned, text.index("error: "), "before anything runs")
        self.assertIn("b.laz: is unusable", text[text.index("error: "):])
        self.assertNotIn("info b", jobs)
        self.assertIn("stitch a", jobs)

    def test_a_killed_program_is_a_failure_with_its_reason(self):
        self.write("c.laz", "kill trim")
        code, text, _ = self.run_it()
        self.assertEqual(code, 1)
        self.assertIn("c.laz: trim: was killed (signal 9)", text)

    def test_tells_where_the_mesh_is_not_as_it_should_be(self):
        self.write("a.laz", "warn stitch")
        code, text, _ = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertIn("cornice-run: warning: stitch: is odd as told", text)

    def test_finds_a_configuration_that_comes_along_by_its_name(self):
        tile = os.path.join(self.folder, "a.laz")
        self.words[-1] = "lidarhd.yaml"
        code, text, _ = self.run_it(tile, "-o", os.path.join(self.folder, "out"), "--dry-run")
        self.assertEqual(code, 0, text)
        self.assertIn("1 tile, 1,000 points", text)
        self.words[-1] = "lidarhdd.yaml"
        code, text, _ = self.run_it(tile)
        self.assertEqual(code, 2)
        self.assertIn("error: lidarhdd.yaml: no such file; those that come along are ", text)
        self.assertIn("lidarhd.yaml", text)

    def test_warns_of_a_lattice_much_finer_than_the_points(self):
        # 1000 points on 100 m x 100 m: 0.1 a cell of 1 m.
        self.configure("step-m: 1\n")
        self.assertNotIn("are few for cells", self.run_it("--dry-run")[1])
        self.configure("step-m: 0.9\n")
        text = self.run_it("--dry-run")[1]
        self.assertIn("0.1 points/m² are few for cells of 0.9 m", text)
        self.assertIn('"step-m: 3.6"', text)

    def test_needs_no_home_to_write_in(self):
        self.environment.pop("XDG_CACHE_HOME", None)
        self.environment["HOME"] = "/proc/nowhere"
        code, text, _ = self.run_it("--until", "info")
        self.assertEqual(code, 0, text)

    def test_says_in_one_line_what_cannot_be_written(self):
        # As a full disk would have it, which a test cannot make.
        os.makedirs(os.path.join(self.folder, "out", "report.html"))
        code, text, _ = self.run_it("--until", "info")
        self.assertEqual(code, 1)
        self.assertNotIn("Traceback", text)
        self.assertIn("report.html: is a directory", text)

    def test_stops_at_the_first_failure_where_asked(self):
        for name in "abc":
            self.write(name + ".laz", "fail normals")
        code, text, jobs = self.run_it("--stop-at-first-failure")
        self.assertEqual(code, 1)
        self.assertEqual(len([job for job in jobs if job.startswith("normals")]), 1, text)

    def test_resumes_after_an_interruption(self):
        self.write("c.laz", "sleep extract")
        process = self.start()
        self.wait_for(process, "extract c")
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 130, err)
        self.assertIn("goes on from here", err)
        self.write("c.laz", "")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertNotIn("info a", jobs)
        self.assertIn("extract c", jobs)

    def test_an_interruption_while_progress_is_told_stops_the_jobs_too(self):
        self.write("c.laz", "sleep extract")
        # Its own process asks it to stop, in the midst of telling how far it is.
        words = list(self.words)
        self.words[2:3] = ["-c", (
            "import os, runpy, signal, sys\n"
            f"sys.path.insert(0, {os.path.dirname(RUN)!r})\n"
            "import watch\n"
            "def show(self, quiet):\n"
            f"    if 'extract c' in open({self.runs!r}).read():\n"
            "        os.kill(os.getpid(), signal.SIGTERM)\n"
            "watch.Watch.show = show\n"
            f"sys.argv[0] = {RUN!r}\n"
            "runpy.run_path(sys.argv[0], run_name='__main__')\n")]
        code, text, _ = self.run_it()
        self.words = words
        self.assertEqual(code, 130, text)
        self.assertIn("goes on from here", text)
        self.write("c.laz", "")
        code, text, again = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertNotIn("info a", again)
        self.assertIn("extract c", again)

    def test_refuses_a_second_run_in_the_same_folder(self):
        self.write("a.laz", "sleep info")
        process = self.start()
        try:
            self.wait_for(process, "info a")
            code, text, _ = self.run_it()
            self.assertEqual(code, 1)
            self.assertIn("another cornice run works there", text)
        finally:
            process.send_signal(signal.SIGTERM)
            process.communicate(timeout=300)

    def test_ends_where_it_is_told_to(self):
        _, _, jobs = self.run_it("--until", "normals")
        self.assertEqual({job.split()[0] for job in jobs}, {"info", "flightlines", "normals"})

    def test_compares_with_an_elevation_model_where_there_is_one(self):
        self.configure("dem: {files: ['*.tif']}\n")
        self.write("ground.tif", "heights")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        # What does not wait for each other begins in any order.
        self.assertEqual(sorted(job for job in jobs if job.startswith(("dem", "compare"))),
                         ["compare dem-files", "dem ground"], text)
        self.assertIn("hlod result", jobs)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "out", "dem.hlod")))
        self.assertIn(os.path.join("compare", "index.html"), text)
        self.write("ground.tif", "other heights")
        self.assertEqual({job.split()[0] for job in self.run_it()[2]},
                         {"dem", "hlod", "compare"})

    def test_fills_from_rasters_and_does_it_again_when_they_change(self):
        self.run_it()
        self.configure("fill-dem: ['*.tif']\n")
        code, text, _ = self.run_it()
        self.assertEqual(code, 2)
        self.assertIn("fill-dem: *.tif: no such file", text)
        self.write("ground.tif", "heights")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertEqual({job.split()[0] for job in jobs},
                         {"solve", "extract", "trim", "remesh", "stitch", "hlod"}, text)
        self.assertEqual(self.run_it()[2], [])
        self.write("ground.tif", "other heights")
        self.assertEqual(len([job for job in self.run_it()[2] if job.startswith("trim")]), 3)

    def test_builds_no_hierarchy_of_a_mesh_that_it_cannot_read(self):
        self.configure("stitch: {format: glb}\n")
        _, _, jobs = self.run_it()
        self.assertNotIn("hlod", {job.split()[0] for job in jobs})
        self.configure("stitch: {format: glb}\nhlod: {partition: octree}\n")
        code, text, _ = self.run_it()
        self.assertEqual(code, 2)
        self.assertIn("hlod: reads .ply", text)

    def test_builds_levels_of_detail_in_regions_and_joins_them(self):
        self.configure("hlod: {regions: 2, partition: octree}\n")
        code, text, jobs = self.run_it()
        self.assertEqual(code, 0, text)
        self.assertEqual(jobs.count("hlod a"), 2, jobs)
        self.assertEqual(jobs[-1], "hlod 1-of-2")
        self.configure("hlod: {regions: 3, partition: octree}\n")
        self.assertEqual(len(self.run_it()[2]), 4)

    def test_refuses_to_end_with_a_stage_that_nobody_asked_for(self):
        code, text, _ = self.run_it("--until", "compare")
        self.assertEqual(code, 2)
        self.assertIn("--until: compare: ", text)

    def test_runs_through_a_cluster_which_plans_each_job_again(self):
        for name in "bc":
            os.remove(os.path.join(self.folder, name + ".laz"))
        profile = os.path.join(self.folder, "site")
        os.makedirs(profile)
        # bash is a cluster that runs a job when it is submitted.
        with open(os.path.join(profile, "config.yaml"), "w", encoding="utf-8") as file:
            file.write("cluster: bash\njobs: 1\n")
        code, text, jobs = self.run_it("--profile", profile, "--until", "solve")
        self.assertEqual(code, 0, text)
        self.assertEqual(jobs, ["info a", "flightlines a", "normals a", "solve a"])

    def test_says_what_is_missing(self):
        self.write("survey.yaml", "output: out\n")
        code, text, _ = self.run_it()
        self.assertEqual(code, 2)
        self.assertIn("tiles: is missing", text)


if __name__ == "__main__":
    unittest.main()
