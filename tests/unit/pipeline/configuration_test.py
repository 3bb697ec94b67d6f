#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user is told who has made a mistake in a configuration."""

import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "pipeline", "scripts"))
import configuration  # noqa: E402

SCHEMA = os.path.join(ROOT, "config", "config.schema.json")


class Configuration(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = os.path.join(self.folder.name, "survey.yaml")

    def tearDown(self):
        self.folder.cleanup()

    def read(self, text):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text)
        return configuration.read(self.path, SCHEMA)

    def error(self, text):
        with self.assertRaises(configuration.ConfigError) as caught:
            self.read(text)
        message = str(caught.exception)
        self.assertTrue(message.startswith(self.path + ": "), message)
        self.assertNotIn("\n", message)
        return message.removeprefix(self.path + ": ")

    def test_shipped_configurations_are_valid(self):
        for name in sorted(os.listdir(os.path.join(ROOT, "config"))):
            if name.endswith(".yaml"):
                with self.subTest(name):
                    configuration.read(os.path.join(ROOT, "config", name), SCHEMA)

    def test_an_empty_section_counts_as_none(self):
        self.assertEqual(self.read("tiles: [a]\nnormals:\n")["normals"], {})

    def test_names_an_unknown_key_and_the_nearest_known_one(self):
        self.assertEqual(self.error("tiels: [a]"),
                         'tiels: is no known key, did you mean "tiles"?')
        self.assertTrue(self.error("normals: {neighbors: 3}").startswith(
            "normals.neighbors: is no known key"))

    def test_names_the_key_of_a_wrong_value(self):
        self.assertEqual(self.error("normals: {k: many}"),
                         "normals.k: 'many' is not of type 'integer'")
        self.assertTrue(self.error("step-m: -1").startswith("step-m: -1 is less than"))
        self.assertTrue(self.error("tiles: []").startswith("tiles: "))
        self.assertTrue(self.error("normals: {classes: [{up-to-m: 3}]}").startswith(
            "normals.classes[0].keep: is missing"))

    def test_names_the_line_of_a_fault_in_the_yaml(self):
        self.assertTrue(self.error("tiles: [a\noutput: b").startswith("line 2: "))
        self.assertEqual(self.error("tiles: [a]\ntiles: [b]"), 'line 2: the key "tiles" stands twice')

    def test_refuses_what_is_no_configuration(self):
        self.assertEqual(self.error(""), "is empty, or no map of keys and values")
        self.assertEqual(self.error("- a\n- b"), "is empty, or no map of keys and values")
        with self.assertRaisesRegex(configuration.ConfigError, "no such file"):
            configuration.read(os.path.join(self.folder.name, "none.yaml"), SCHEMA)

    def test_finds_tiles_by_pattern_folder_and_name(self):
        os.makedirs(os.path.join(self.folder.name, "tiles"))
        for name in ("tiles/b.laz", "tiles/a.LAS", "tiles/c.las.zip", "tiles/notes.txt", "d.laz"):
            with open(os.path.join(self.folder.name, name), "w", encoding="utf-8"):
                pass
        def names(*patterns):
            return [os.path.relpath(found, self.folder.name) for found in
                    configuration.files(self.path, "tiles", patterns, (".laz", ".las", ".las.zip"))]
        self.assertEqual(names("tiles"), ["tiles/a.LAS", "tiles/b.laz", "tiles/c.las.zip"])
        self.assertEqual(names("tiles/*.laz", "d.laz", "./d.laz"), ["d.laz", "tiles/b.laz"])
        with self.assertRaisesRegex(configuration.ConfigError, r"tiles: none/\*\.laz: no such file"):
            names("none/*.laz")
        os.makedirs(os.path.join(self.folder.name, "empty"))
        with self.assertRaisesRegex(configuration.ConfigError, r"tiles: empty: holds no \.laz"):
            names("empty")

    def test_names_what_a_section_needs(self):
        self.assertEqual(self.error("compare: {spacing: 1}"), 'compare: needs the section "dem"')
        self.assertEqual(self.error("dem: {no-data: 0}"), "dem.files: is missing")
        self.assertTrue(self.error("hlod: {partition: cubes}").startswith("hlod.partition: "))
        self.assertTrue(self.error("stitch: {format: obj}\nhlod: {levels: 3}").startswith("hlod: "))


if __name__ == "__main__":
    unittest.main()
