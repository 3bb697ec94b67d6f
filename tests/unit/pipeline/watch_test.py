#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a large survey's plan and its progress know, without running anything."""

import os
import resource
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "pipeline", "scripts"))
import programs  # noqa: E402
import records  # noqa: E402
import stages  # noqa: E402
import todo  # noqa: E402
import watch  # noqa: E402


def grid_plan(folder, side):
    """side x side tiles of 1 km and 20 M points."""
    def name(x, y):
        return f"{x}_{y}"
    tiles = {}
    for x in range(side):
        for y in range(side):
            around = [name(i, j) for i in (x - 1, x, x + 1) for j in (y - 1, y, y + 1)
                      if (i, j) != (x, y) and 0 <= i < side and 0 <= j < side]
            tiles[name(x, y)] = {"path": f"{x}_{y}.laz", "points": 20000000, "neighbours": around,
                                 "box": [1000.0 * x, 1000.0 * y, 1000.0 * x + 1000.0,
                                         1000.0 * y + 1000.0], "modified": [1, 1]}
    plan = {"output": folder, "tiles": tiles, "until": "stitch", "halo_m": 40.0, "step_m": 0.5,
            "config": {}, "dem": {}}
    plan["fingerprints"] = todo.fingerprints(plan, "1.0")
    return plan


def end(plan, stage, tile, found, status="done"):
    before = [job[:2] for job in stages.upstream(plan, stage, tile)]
    record = {"status": status, "exit_code": 0, "message": "", "id": f"{stage} {tile}",
              "fingerprint": plan["fingerprints"][stage][tile],
              "inputs": records.inputs_digest(before, found)}
    records.write_json(records.record_path(plan, stage, tile), record)
    for output in stages.STAGES[stage].outputs(plan, tile):
        os.makedirs(os.path.dirname(output), exist_ok=True)
        with open(output, "w", encoding="utf-8"):
            pass
    found[stage, tile] = record


class LargeSurvey(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.plan = grid_plan(folder.name, 10)
        self.found = {}

    def end_stages(self, *names):
        for name in names:
            for tile in stages.tiles_of(self.plan, stages.STAGES[name]):
                end(self.plan, name, tile, self.found)

    def test_three_jobs_of_the_scheduler_do_a_tile(self):
        groups = [[stage.name for stage in group] for group in stages.chains(self.plan)]
        self.assertEqual(groups, [["info"], ["flightlines"], ["normals", "solve"],
                                  ["extract", "trim", "remesh"], ["stitch"]])
        self.plan["until"] = "trim"
        self.assertEqual([stage.name for stage in stages.chains(self.plan)[-1]], ["extract", "trim"])

    def test_everything_is_to_do_at_first_and_what_has_ended_is_not(self):
        self.assertEqual(len(todo.find(self.plan)[0]), 602)
        self.end_stages("info", "flightlines")
        left, found = todo.find(self.plan)
        self.assertEqual(todo.counts(left), {"normals": 100, "solve": 100, "extract": 100,
                                             "trim": 100, "remesh": 100, "stitch": 1})
        self.assertEqual(len(found), 101)

    def test_a_job_done_again_takes_with_it_what_was_made_from_it(self):
        self.end_stages("info", "flightlines", "normals", "solve", "extract")
        self.assertEqual(todo.counts(todo.find(self.plan)[0]),
                         {"trim": 100, "remesh": 100, "stitch": 1})
        # As another run might have left it, which was stopped after this job.
        self.found["normals", "5_5"] = {}
        end(self.plan, "solve", "5_5", self.found)
        left = set(todo.find(self.plan)[0])
        self.assertIn(("solve", "5_5"), left)
        self.assertEqual({tile for stage, tile in left if stage == "extract"},
                         {f"{x}_{y}" for x in (4, 5, 6) for y in (4, 5, 6)})

    def test_progress_reads_each_record_once_and_lists_only_what_changed(self):
        self.end_stages("info")
        view = watch.Watch(self.plan, todo.find(self.plan)[0])
        view.refresh()
        self.assertNotIn("flightlines", view.line())
        end(self.plan, "flightlines", "survey", self.found)
        end(self.plan, "normals", "0_0", self.found)
        with mock.patch.object(watch.records, "read", wraps=records.read) as read:
            view.refresh()
            self.assertEqual(read.call_count, 2)
            view.refresh()
            self.assertEqual(read.call_count, 2)
        self.assertIn("(normals 1/100)", view.line())
        for folder in view.folders:
            folder.TICK_NS = 0
        view.refresh()
        with mock.patch("os.listdir", side_effect=AssertionError("listed again")):
            view.refresh()

    def test_progress_counts_failures_and_tells_the_time_left(self):
        view = watch.Watch(self.plan, todo.find(self.plan)[0])
        with mock.patch("time.time", return_value=1000.0):
            end(self.plan, "info", "0_0", self.found)
            view.refresh()
            self.assertIsNone(view.seconds_left())
        end(self.plan, "info", "0_1", self.found, status="failed")
        with mock.patch("time.time", return_value=1010.0):
            view.refresh()
            share = view.expected["info", "0_1"] / view.left
            self.assertAlmostEqual(view.seconds_left() * share, 10.0)
        self.assertIn("1 failed", view.line())

    def test_the_time_left_falls_while_a_job_runs_as_expected_and_grows_when_it_takes_longer(self):
        view = watch.Watch(self.plan, todo.find(self.plan)[0])
        with mock.patch("time.time", return_value=1000.0) as now:
            end(self.plan, "info", "0_0", self.found)
            view.refresh()
            now.return_value = 1010.0
            end(self.plan, "info", "0_1", self.found)
            view.refresh()
            at_end = view.seconds_left()
            # At this pace the longest job of a tile that may run now takes so long.
            longest = 10.0 * view.under_way() / view.expected["info", "0_1"]
            now.return_value = 1010.0 + 0.5 * longest
            self.assertAlmostEqual(view.seconds_left(), at_end - 0.5 * longest)
            now.return_value = 1010.0 + 2.0 * longest
            late = view.seconds_left()
            now.return_value = 1010.0 + 4.0 * longest
            self.assertGreater(view.seconds_left(), late)

    def test_a_job_asks_for_the_memory_that_its_points_and_its_ground_take(self):
        # (points in a square kilometre, stage, MiB that were measured)
        for points, stage, measured in (
                (20400000, "normals", 1350), (20400000, "solve", 3670), (20400000, "extract", 2590),
                (20400000, "trim", 1470), (20400000, "remesh", 2410), (280000, "normals", 104),
                (280000, "solve", 833), (280000, "extract", 690), (280000, "trim", 1001),
                (280000, "remesh", 1312)):
            with self.subTest(f"{points} points, {stage}"):
                self.plan["tiles"]["5_5"]["points"] = points
                asked = stages.memory_mb(self.plan, stage, "5_5")
                self.assertGreater(asked, 1.2 * measured)
                self.assertLess(asked, 300 + 2.5 * measured)

    def test_a_command_line_may_name_every_tile(self):
        hard = resource.getrlimit(resource.RLIMIT_STACK)[1]
        if hard != resource.RLIM_INFINITY and hard < 24 * 2**20:
            self.skipTest("the stack may not grow here")

        def run(allow):
            """What a process says, to which the system gives the usual stack of 8 MiB."""
            script = (f"import programs; {allow}; "
                      "print(programs.run_measured(['/bin/true'] + ['x' * 250] * 10000)[0])")
            return subprocess.run(
                [sys.executable, "-B", "-c", script], capture_output=True, text=True, check=False,
                cwd=os.path.dirname(programs.__file__), preexec_fn=lambda: resource.setrlimit(
                    resource.RLIMIT_STACK, (8 * 2**20, hard)))

        self.assertIn("Argument list too long", run("pass").stderr)
        allowed = run("programs.allow_long_command_lines()")
        self.assertEqual(allowed.stdout.strip(), "0", allowed.stderr)


if __name__ == "__main__":
    unittest.main()
