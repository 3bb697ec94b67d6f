# SPDX-License-Identifier: GPL-3.0-or-later
"""What the stages counted and measured, summed up over the tiles for the report."""

import re
import statistics

import page


def words(name):
    """A figure's name as a reader knows it: largest_move_m -> largest move, m."""
    units = {"m": "m", "m2": "m²", "deg": "degrees", "s": "s"}
    parts = name.split("_")
    if len(parts) > 1 and parts[-2:] == ["per", "s"]:
        return " ".join(parts[:-2]) + " per second"
    if len(parts) > 1 and parts[-1] in units:
        return " ".join(parts[:-1]) + ", " + units[parts[-1]]
    return " ".join(parts)


def flat(figures, before=""):
    """(name, number) of all numbers, those in groups with the group's name before theirs."""
    for name, value in figures.items():
        if isinstance(value, dict):
            yield from flat(value, before + words(name) + ": ")
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            yield before + words(name), value


def numbers_of(reports, part):
    """{name: its values over the tiles} of the numbers in a part of the reports."""
    values = {}
    for report in reports.values():
        for name, value in flat(report[part]):
            values.setdefault(name, []).append(value)
    return values


def rows_of(reports):
    """(rows of figures that are not zero everywhere, names of counts that are)"""
    rows, zero = [], []
    for name, values in numbers_of(reports, "counts").items():
        if any(values):
            rows.append([name, min(values), statistics.median(values), max(values), sum(values)])
        else:
            zero.append(name)
    rows += [[name, min(values), statistics.median(values), max(values), ""]
             for name, values in numbers_of(reports, "quality").items()]
    return rows, zero


def tables_within(report):
    """The lists of groups among a report's figures, each as a table of its own."""
    text = ""
    for name, entries in report["quality"].items():
        if isinstance(entries, list) and entries and isinstance(entries[0], dict):
            keys = list(entries[0])
            text += page.folded(words(name), page.table(
                [(words(key), True) for key in keys],
                [[entry.get(key, "") for key in keys] for entry in entries]))
    return text


def table(reports):
    """All figures of a stage: one value for a job of the whole survey, a range over tiles."""
    rows, zero = rows_of(reports)
    text = ""
    if rows and len(reports) == 1:
        text = page.table([("figure", False), ("value", True)], [row[0:2] for row in rows])
    elif rows:
        text = page.table([("figure", False), ("least", True), ("median", True), ("most", True),
                           ("sum", True)], rows)
    if zero:
        text += page.paragraph("None: " + ", ".join(zero) + ".", "soft")
    if len(reports) == 1:
        text += tables_within(next(iter(reports.values())))
    return text


# A tile's file at the beginning of a message: its own, or that of a neighbour it reads.
TILE_FILE = re.compile(r"^.+?\.(las\.zip|laz|las): ", re.IGNORECASE)


def warnings(reports):
    """(text, tiles) of the warnings; those that differ in their numbers and files only are one."""
    found = {}
    for tile, report in reports.items():
        for text in report["warnings"]:
            kind = re.sub(rf"\b{re.escape(tile)}\b", "", TILE_FILE.sub("", text))
            kind = re.sub(r"\d+(\.\d+)?", "0", kind)
            found.setdefault(kind, []).append((text, tile))
    for alike in found.values():
        text, tiles = alike[0][0], list(dict.fromkeys(tile for _, tile in alike))
        if len(tiles) == 1 < len(alike):
            text += f" (and {len(alike) - 1} more like it)"
        yield text, tiles


# (stage, part of its report, figure or its path, how the tiles' values become one, what it says)
RESULTS = (
    ("flightlines", "counts", "lines", sum, "flight lines"),
    ("flightlines", "counts", "lines_with_trajectory", sum, "flight lines with the sensor's path"),
    ("normals", "counts", "points", sum, "points with a normal, halos included"),
    ("normals", "counts", "unsettled", sum, "points dropped because the side of their normal is unknown"),
    ("stitch", "counts", "triangles", sum, "triangles of the mesh"),
    ("stitch", "counts", "vertices", sum, "vertices of the mesh"),
    ("trim", "quality", "area_m2", sum, "surface, m²"),
    ("trim", "quality", "bridged_area_m2", sum, "of it bridged, m²"),
    ("remesh", "quality", "hausdorff_m", max, "greatest distance that remeshing moved the surface, m"),
    ("remesh", "quality", "all triangles/share_min_angle_20", min,
     "share of triangles without an angle below 20 degrees, worst tile"),
    ("stitch", "quality", "open_edges", sum, "open edges on inner borders"),
    ("stitch", "quality", "t_vertices", sum, "vertices inside an edge across a border"),
    ("stitch", "quality", "mismatched_vertices", sum, "vertices without their like across a border"),
    ("stitch", "quality", "non_manifold_edges", sum, "edges of more than two triangles"),
    ("stitch", "quality", "turned_triangles", sum,
     "pairs of triangles that face opposite sides across a border"),
    ("hlod", "counts", "triangles_all_levels", sum, "triangles in all levels of detail"),
    ("compare", "quality", "vertical_rms_m", max, "mesh against elevation model, rms of height, m"),
    ("compare", "quality", "overhang_m2_b", max, "overhangs of the mesh, m²"),
)


def value_at(group, name):
    """A figure by its path, or None where it is no number."""
    for key in name.split("/"):
        group = group.get(key) if isinstance(group, dict) else None
    return group if isinstance(group, (int, float)) else None


def results(reports):
    """The figures that most readers look for first, of those stages that ran."""
    rows = []
    for stage, part, name, fold, title in RESULTS:
        values = [value for report in reports.get(stage, {}).values()
                  if (value := value_at(report[part], name)) is not None]
        if values:
            rows.append([title, fold(values)])
    return page.table([("result", False), ("", True)], rows) if rows else ""
