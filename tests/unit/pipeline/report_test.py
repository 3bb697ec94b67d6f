#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a survey: it says what the stages said, and needs nothing beside it."""

import base64
import html.parser
import json
import os
import pathlib
import resource
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "pipeline" / "scripts"))
import records  # noqa: E402
import report  # noqa: E402

PNG = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGA"
                       "WjR9awAAAABJRU5ErkJggg==")


def stage_report(**changes):
    return {
        "tool": "cornice-info", "seconds": 2.5, "peak_memory_bytes": 3 * 2**20,
        "parameters": {"neighbours": 16}, "counts": {"points": 20400000}, "quality": {},
        "machine": {"cpu": "a processor", "cores": 2, "memory_bytes": 2**33, "os": "an os"},
        "steps": [{"name": "read", "seconds": 0.5}], "warnings": [], **changes}


class Links(html.parser.HTMLParser):
    """Collects where a page points to, and checks that its elements are closed in order."""

    EMPTY = {"meta", "img"}

    def __init__(self):
        super().__init__()
        self.targets, self.open, self.text = [], [], ""

    def handle_starttag(self, tag, attrs):
        self.targets += [value for name, value in attrs if name in ("src", "href")]
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"{tag} closes out of order"

    def handle_data(self, data):
        self.text += data


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # A picture program that draws one pixel, whatever is asked for.
        programs = self.folder / "programs"
        programs.mkdir()
        (self.folder / "pixel.png").write_bytes(PNG)
        picture = programs / "cornice-picture"
        picture.write_text("#!/bin/sh\nwhile [ \"$1\" != -o ]; do shift; done\n"
                           f"cp '{self.folder}/pixel.png' \"$2\"\n", encoding="utf-8")
        picture.chmod(0o755)
        tile = {"path": "a&b.laz", "points": 1000, "bytes": 1, "box": [0, 0, 100, 100],
                "neighbours": []}
        self.plan = {"output": str(self.folder), "programs": str(programs), "until": "info",
                     "tiles": {"a": tile, "b": dict(tile, path="b.laz")}, "unusable": {},
                     "warnings": [], "crs": "EPSG:2154", "version": "cornice 1.2.3",
                     "config": {"title": "A & B"}}

    def finish(self, tile, content, stage="info"):
        for target, value in ((records.record_path(self.plan, stage, tile),
                               {"status": "done", "message": "", "seconds": content["seconds"],
                                "cpu_seconds": 2 * content["seconds"],
                                "peak_memory_bytes": content["peak_memory_bytes"]}),
                              (records.report_path(self.plan, stage, tile), content)):
            os.makedirs(os.path.dirname(target), exist_ok=True)
            pathlib.Path(target).write_text(json.dumps(value), encoding="utf-8")

    def page(self, failed=()):
        parser = Links()
        with open(report.write(self.plan, list(failed)), encoding="utf-8") as file:
            parser.feed(file.read())
        parser.close()
        self.assertEqual(parser.open, [])
        return parser

    def test_sums_up_what_the_jobs_reported(self):
        self.finish("a", stage_report())
        self.finish("b", stage_report(seconds=4.0))
        text = self.page().text
        for wanted in ("A & B", "2 tiles", "6.5", "13", "3.0 MiB", "40,800,000", "a processor", "EPSG:2154"):
            self.assertIn(wanted, text)

    def test_holds_its_pictures(self):
        self.finish("a", stage_report())
        targets = self.page().targets
        self.assertEqual(set(targets), {"data:image/png;base64," + base64.b64encode(PNG).decode()})

    def test_shows_the_comparison_and_where_the_rest_of_it_is(self):
        self.plan.update(until="compare", dem={}, config={"dem": {"files": ["a.tif"]}})
        self.finish("survey", stage_report(), "compare")
        self.assertIn("compare/index.html", self.page().targets)
        shown = len(self.page().targets)
        os.makedirs(self.folder / "compare")
        (self.folder / "compare" / "difference.png").write_bytes(PNG)
        page = self.page()
        self.assertEqual(len(page.targets), shown + 1)
        self.assertIn("Mesh against elevation model", page.text)

    def test_says_so_where_a_picture_could_not_be_drawn(self):
        self.finish("a", stage_report())
        os.remove(os.path.join(self.plan["programs"], "cornice-picture"))
        with open(os.path.join(self.plan["programs"], "cornice-picture"), "w",
                  encoding="utf-8") as program:
            program.write("#!/bin/sh\nexit 1\n")
        os.chmod(os.path.join(self.plan["programs"], "cornice-picture"), 0o755)
        page = self.page()
        self.assertEqual(page.targets, [])
        self.assertIn("could not be drawn", page.text)

    def view(self, script):
        """The report of a survey with levels of detail where cornice-viewer is such a script."""
        self.plan.update(until="hlod")
        self.finish("survey", stage_report(), "hlod")
        if script:
            viewer = self.folder / "programs" / "cornice-viewer"
            viewer.write_text("#!/bin/sh\n" + script, encoding="utf-8")
            viewer.chmod(0o755)
        page = self.page()
        views = [target for target in page.targets if target.startswith("data:image/jpeg")]
        return views, page.text

    def test_shows_the_levels_of_detail_as_the_viewer_does(self):
        jpeg = self.folder / "drawn.jpg"
        jpeg.write_bytes(b"as if it were a picture")
        views, text = self.view('echo "$@" >> "$0.log"\nwhile [ "$1" != -o ]; do shift; done\n'
                                f"cp '{jpeg}' \"$2\"\n")
        self.assertEqual(len(views), len(report.VIEWS))
        for _, caption, _, _ in report.VIEWS:
            self.assertIn(caption, text)
        asked = (self.folder / "programs" / "cornice-viewer.log").read_text(encoding="utf-8")
        for wanted in ("survey.hlod", "--headless", "--view overview", "--view steepest"):
            self.assertIn(wanted, asked)

    def test_has_each_view_looked_for_once(self):
        self.view('printf "%s\\t" "$@" >> "$0.log"\necho >> "$0.log"\n'
                  'while [ "$1" != -o ]; do shift; done\n: > "$2"\n')
        lines = (self.folder / "programs" / "cornice-viewer.log").read_text(
            encoding="utf-8").splitlines()
        known = set()
        for line in lines:
            words = line.split("\t")
            view = words[words.index("--view") + 1]
            key = "--camera" if view in known else "--save-camera"
            self.assertTrue(words[words.index(key) + 1].endswith(f"pictures/{view}.json"), line)
            known.add(view)
        self.assertLess(len(known), len(lines), "no view is used again")

    def test_shows_the_other_pictures_of_the_viewer_where_one_fails(self):
        views, text = self.view(
            'case "$*" in *"--view overview"*) echo "cornice-viewer: error: broken" >&2; exit 1;; '
            'esac\nwhile [ "$1" != -o ]; do shift; done\n: > "$2"\n')
        self.assertEqual(len(views), len(report.VIEWS) - 1)
        self.assertIn('The picture "overview" is missing: broken.', text)
        self.assertNotIn("No pictures by cornice-viewer", text)

    def test_looks_for_a_view_again_where_its_first_picture_fails(self):
        views, _ = self.view(
            'echo "$@" >> "$0.log"\ncase "$*" in *"pictures/steepest.jpg"*) exit 1;; esac\n'
            'while [ "$1" != -o ]; do shift; done\n: > "$2"\n')
        lines = (self.folder / "programs" / "cornice-viewer.log").read_text(
            encoding="utf-8").splitlines()
        self.assertEqual(len(views), len(report.VIEWS) - 1)
        saved = [line for line in lines if "--save-camera" in line and "--view steepest" in line]
        self.assertEqual(len(saved), 2, lines)

    def test_says_in_one_line_why_there_is_nothing_of_the_viewer(self):
        for script, reason, patience_s in (
                ("", "cornice-viewer does not start (No such file or directory)", 300),
                ("exec sleep 600\n", "cornice-viewer took longer than 0.2 s", 0.2),
                ("exit 7\n", "cornice-viewer ended with 7", 300),
                ("echo 'cornice-viewer: error: OpenGL: is older than 4.5' >&2\nexit 1\n",
                 "OpenGL: is older than 4.5", 300)):
            with self.subTest(reason), mock.patch.object(report, "MOST_VIEW_SECONDS", patience_s):
                views, text = self.view(script)
                self.assertEqual(views, [])
                self.assertEqual(text.count(f"No pictures by cornice-viewer: {reason}."), 1, text)
                self.assertEqual(text.count("No pictures by cornice-viewer"), 1)

    def test_says_once_what_many_tiles_warn_of(self):
        self.finish("a", stage_report(warnings=["is 0.11 m off, more than 0.1"]))
        self.finish("b", stage_report(warnings=["is 0.132 m off, more than 0.1", "is of b"]))
        text = self.page().text
        self.assertIn("is 0.11 m off, more than 0.1 (and like it on 1 more tiles)", text)
        self.assertNotIn("0.132", text)
        self.assertIn("is of b", text)

    def test_shows_figures_in_groups_and_names_those_that_are_nought(self):
        self.plan["tiles"].pop("b")
        self.finish("a", stage_report(
            counts={"points": 7, "invalid_time": 0},
            quality={"largest_move_m": 0.25, "inner": {"share_min_angle_20": 0.99},
                     "levels": [{"level": 0, "cells": 1}, {"level": 1, "cells": 4}]}))
        text = self.page().text
        for wanted in ("largest move, m", "inner: share min angle 20", "None: invalid time.", "cells"):
            self.assertIn(wanted, text)

    def test_leaves_nothing_half_written_where_it_does_not_fit(self):
        report.write(self.plan, [])
        whole = (self.folder / "report.html").read_bytes()
        limit = resource.getrlimit(resource.RLIMIT_FSIZE)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_FSIZE, limit)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))
        with self.assertRaises(OSError):
            records.write_text(str(self.folder / "report.html"), "x" * 100000)
        self.assertEqual((self.folder / "report.html").read_bytes(), whole)
        self.assertEqual(list(self.folder.glob("*partial*")), [])

    def test_shows_warnings_and_failures_as_text(self):
        self.finish("a", stage_report(warnings=["<b>1 & 2</b>"]))
        self.plan["unusable"] = {"c.laz": "is <empty>"}
        text = self.page([("b", "info", "<i>no</i>")]).text
        for wanted in ("<b>1 & 2</b>", "c.laz: is <empty>", "b.laz: info: <i>no</i>",
                       "What is not whole (2)"):
            self.assertIn(wanted, text)


if __name__ == "__main__":
    unittest.main()
