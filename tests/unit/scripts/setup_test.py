#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/setup: its lists, its answers, and what it says where it can do nothing."""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]


def setup(*arguments, path_first=None):
    environment = dict(os.environ)
    if path_first:
        environment["PATH"] = f"{path_first}:{environment['PATH']}"
    return subprocess.run([ROOT / "scripts/setup", *arguments], capture_output=True, text=True,
                          env=environment, stdin=subprocess.DEVNULL, check=False)


class Setup(unittest.TestCase):
    def setUp(self):
        self.packages = setup("--print").stdout.split()
        self.assertIn("libgdal-dev", self.packages)

    def with_commands(self, **bodies):
        """A folder of shell scripts that stand in for the system's commands."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for name, body in bodies.items():
            file = pathlib.Path(folder.name, name.replace("_", "-"))
            file.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
            file.chmod(0o755)
        return folder.name

    def test_names_no_package_twice(self):
        self.assertEqual(len(self.packages), len(set(self.packages)))

    def test_installs_every_package_that_cmake_asks_for(self):
        text = (ROOT / "cmake/CorniceDependencies.cmake").read_text(encoding="utf-8")
        asked = set(re.findall(r"\b(?:lib[a-z0-9-]+|nlohmann-json3)-dev\b", text))
        other_release = {"libgeographiclib-dev", "libgeographic-dev"}
        self.assertGreater(len(asked), 10)
        self.assertLessEqual(asked - other_release, set(self.packages))
        self.assertEqual(len(other_release & set(self.packages)), 1)

    def test_every_package_is_in_the_table_of_dependencies(self):
        table = (ROOT / "docs/dependencies.md").read_text(encoding="utf-8")
        for package in self.packages + setup("--print", "lint", "fuzz").stdout.split():
            self.assertIn(f"`{package}`", table)

    def test_says_nothing_and_asks_once_where_all_is_there(self):
        folder = self.with_commands(
            dpkg_query='echo asked >> "$0.log"\nshift 2\nfor p; do echo installed:$p; done')
        result = setup(path_first=folder)
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "", ""))
        asked = pathlib.Path(folder, "dpkg-query.log").read_text(encoding="utf-8")
        self.assertEqual(asked, "asked\n")

    def test_lists_everything_on_a_bare_machine(self):
        # dpkg-query fails where it knows none of the names.
        folder = self.with_commands(dpkg_query="exit 1")
        result = setup("--check", path_first=folder)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stdout.split(), self.packages)

    def test_counts_a_package_that_was_removed_but_left_its_configuration_as_missing(self):
        folder = self.with_commands(
            dpkg_query="shift 2\nfor p; do case $p in\n"
            "libgdal-dev) echo config-files:$p ;; *) echo installed:$p ;; esac; done")
        result = setup("--check", path_first=folder)
        self.assertEqual((result.returncode, result.stdout), (1, "libgdal-dev\n"))

    def test_says_so_where_it_cannot_become_root(self):
        folder = self.with_commands(dpkg_query="exit 1", id="echo 1000", sudo="exit 1")
        result = setup(path_first=folder)
        self.assertEqual(result.returncode, 1)
        self.assertIn("sudo asks for a password and there is no terminal", result.stderr)
        self.assertIn("as root", result.stderr)

    def test_refuses_unknown_options_and_groups(self):
        self.assertEqual(setup("--frobnicate").returncode, 2)
        result = setup("--check", "everything")
        self.assertEqual(result.returncode, 2)
        self.assertIn("everything", result.stderr)


if __name__ == "__main__":
    unittest.main()
