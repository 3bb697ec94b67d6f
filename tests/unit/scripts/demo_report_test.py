#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/demo_report.py: the page holds what the reports say, and needs nothing beside it."""

import base64
import html.parser
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "scripts/demo_report.py"
PNG = base64.b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGA"
                       "WjR9awAAAABJRU5ErkJggg==")


def report(tool, **changes):
    return {
        "tool": tool, "version": "0.1.0", "started": "2024-05-01T12:00:00Z", "seconds": 2.5,
        "peak_memory_bytes": 3 * 2**20, "parameters": {"neighbours": 16},
        "machine": {"cpu": "a processor", "cores": 2, "memory_bytes": 2**33, "os": "an os"},
        "inputs": [{"path": "a.laz", "bytes": 2048}], "outputs": [], "counts": {"points": 20400000},
        "steps": [{"name": "read", "seconds": 0.5}], "quality": {}, "warnings": [], **changes}


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


class DemoReport(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_script(self, *reports, pictures=()):
        files = []
        for number, content in enumerate(reports):
            files.append(self.folder / f"{number}.json")
            files[-1].write_text(json.dumps(content), encoding="utf-8")
        command = [sys.executable, "-B", SCRIPT, *files, "-o", self.folder / "page.html",
                   "--title", "A & B"]
        for picture in pictures:
            command += ["--picture", picture]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def page(self):
        parser = Links()
        parser.feed((self.folder / "page.html").read_text(encoding="utf-8"))
        parser.close()
        self.assertEqual(parser.open, [])
        return parser

    def test_shows_every_stage_with_its_counts(self):
        result = self.run_script(report("cornice-one"), report("cornice-two", seconds=4.0))
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        text = self.page().text
        for wanted in ("A & B", "cornice-one", "cornice-two", "20,400,000", "4.0", "3.0 MiB"):
            self.assertIn(wanted, text)

    def test_holds_its_pictures(self):
        picture = self.folder / "p.png"
        picture.write_bytes(PNG)
        result = self.run_script(report("a"), pictures=[f"{picture}=a view = of a wall"])
        self.assertEqual(result.returncode, 0, result.stderr)
        page = self.page()
        self.assertEqual(page.targets, ["data:image/png;base64," + base64.b64encode(PNG).decode()])
        self.assertIn("a view = of a wall", page.text)

    def test_shows_warnings_as_text(self):
        result = self.run_script(report("a", warnings=["<b>1 & 2</b>"]))
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("<b>1 & 2</b>", self.page().text)

    def test_names_the_file_that_is_no_report(self):
        incomplete = report("a")
        del incomplete["counts"]
        result = self.run_script(incomplete)
        self.assertEqual(result.returncode, 3)
        self.assertIn("0.json", result.stderr)
        self.assertIn("counts", result.stderr)
        self.assertFalse((self.folder / "page.html").exists())

    def test_names_the_picture_that_is_missing(self):
        result = self.run_script(report("a"), pictures=["nowhere.png=x"])
        self.assertEqual(result.returncode, 3)
        self.assertIn("nowhere.png", result.stderr)


if __name__ == "__main__":
    unittest.main()
