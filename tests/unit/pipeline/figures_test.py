#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report sums up of the tiles' figures and warnings."""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "pipeline" / "scripts"))
import figures  # noqa: E402


def reports_with(**warnings):
    return {tile: {"warnings": texts} for tile, texts in warnings.items()}


class Warnings(unittest.TestCase):
    def test_a_warning_of_a_file_that_several_tiles_read_is_one(self):
        found = list(figures.warnings(reports_with(
            a=["/data/a.laz: has no heights", "/data/b 2.LAS: has no heights"],
            b=["/data/a.laz: has no heights", "other"])))
        self.assertEqual(found, [("/data/a.laz: has no heights", ["a", "b"]), ("other", ["b"])])

    def test_several_of_one_job_are_counted_as_such(self):
        found = list(figures.warnings(reports_with(
            survey=["line 1: is 4.5 m off", "line 2: is 12 m off", "line 3: is 1 m off"])))
        self.assertEqual(found, [("line 1: is 4.5 m off (and 2 more like it)", ["survey"])])


class Results(unittest.TestCase):
    def test_the_worst_tile_tells_the_shape_of_triangles(self):
        def remeshed(share):
            return {"counts": {}, "quality": {"hausdorff_m": 0.04, "all triangles": {
                "share_min_angle_20": share}}}
        text = figures.results({"remesh": {"a": remeshed(0.998), "b": remeshed(0.985)}})
        self.assertIn("0.985", text)
        self.assertNotIn("0.998", text)

    def test_what_no_stage_has_counted_is_left_out(self):
        self.assertEqual(figures.results({"remesh": {"a": {"counts": {}, "quality": {}}}}), "")


if __name__ == "__main__":
    unittest.main()
