# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a survey's run: one HTML page that needs no other file."""

import os
import statistics
import subprocess

import page
import records
import stages

# What a picture shows at most; a larger survey shows its first tiles.
MOST_MESHES_DRAWN = 36
MOST_POINTS_DRAWN = 30_000_000


def read_reports(plan, found):
    """{stage: {tile: report of the stage's program}} of all jobs that succeeded and left one."""
    reports = {}
    for (stage, tile), record in found.items():
        target = records.report_path(plan, stage, tile)
        if record["status"] == "done" and os.path.exists(target):
            reports.setdefault(stage, {})[tile] = records.read_json(target)
    return reports


def stage_table(plan, found, reports):
    """found: the records of all jobs that ended, {(stage, tile): record}."""
    head = [("stage", False), ("jobs", True), ("seconds", True), ("longest", True),
            ("CPU seconds", True), ("peak memory", True), ("warnings", True), ("not done", True)]
    rows = []
    for stage in stages.active(plan):
        ended = [record for job, record in found.items()
                 if job[0] == stage.name and record["status"] == "done"]
        count = len(stages.tiles_of(plan, stage))
        rows.append([stage.name, count, *(round(value, 1) for value in (
            sum(record["seconds"] for record in ended),
            max((record["seconds"] for record in ended), default=0.0),
            sum(record["cpu_seconds"] for record in ended))),
            page.bytes_text(max((record["peak_memory_bytes"] for record in ended), default=0)),
            sum(len(report["warnings"]) for report in reports.get(stage.name, {}).values()),
            count - len(ended)])
    rows.append(["all", *(round(sum(row[column] for row in rows), 1) for column in (1, 2)), "",
                 round(sum(row[4] for row in rows), 1), "", *(sum(row[column] for row in rows)
                                                              for column in (6, 7))])
    return page.table(head, rows)


def numbers_of(reports, part):
    """{name: its values over the tiles} of the numbers in a part of the reports."""
    values = {}
    for report in reports.values():
        for name, value in report[part].items():
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                values.setdefault(name, []).append(value)
    return values


def figures_table(reports):
    head = [("figure", False), ("least", True), ("median", True), ("most", True), ("sum", True)]
    rows = [[name, min(values), statistics.median(values), max(values), sum(values)]
            for name, values in numbers_of(reports, "counts").items()]
    rows += [[name, min(values), statistics.median(values), max(values), ""]
             for name, values in numbers_of(reports, "quality").items()]
    return page.table(head, rows) if rows else ""


def stage_section(name, reports):
    warnings = {}
    for tile, report in reports.items():
        for text in report["warnings"]:
            warnings.setdefault(text, []).append(tile)
    parts = [f"<h2>{page.escape(stages.STAGES[name].title)}</h2>"]
    for text, tiles in warnings.items():
        parts.append(page.paragraph(text if len(tiles) == 1 else f"{text} ({len(tiles)} tiles)",
                                    "warning"))
    parts.append(page.folded("Figures", figures_table(reports), is_open=True))
    steps = {}
    for report in reports.values():
        for step in report["steps"]:
            steps.setdefault(step["name"], []).append(step["seconds"])
    parts.append(page.folded("Steps", page.table(
        [("step", False), ("seconds, all tiles", True), ("longest", True)],
        [[step, round(sum(times), 2), round(max(times), 2)] for step, times in steps.items()])))
    first = next(iter(reports.values()))
    parts.append(page.folded("Parameters of the first job", page.table(
        [("parameter", False), ("value", False)],
        [[key, ", ".join(map(str, value)) if isinstance(value, list) else value]
         for key, value in first["parameters"].items()])))
    return "".join(parts)


def failure_section(plan, failed):
    lines = [f"{name}: {problem}" for name, problem in plan["unusable"].items()]
    for tile, stage, message in failed:
        lines.append(f"{records.label(plan, tile)}: {stage}: {message}")
    if not lines:
        return ""
    title = f"<h2>What is not whole ({len(lines)})</h2>"
    return title + "".join(page.paragraph(line, "failure") for line in lines)


def draw(plan, name, words):
    """One picture by cornice-picture; its path, or None with a note in the log."""
    target = records.path(plan, "pictures", name + ".png")
    os.makedirs(os.path.dirname(target), exist_ok=True)
    log_path = records.path(plan, "logs", "pictures", name + ".log")
    os.makedirs(os.path.dirname(log_path), exist_ok=True)
    command = [os.path.join(plan["programs"], "cornice-picture")] + words + [
        "-o", target, "--overwrite", "--no-progress"]
    with open(log_path, "w", encoding="utf-8") as log:
        code = subprocess.run(command, stdout=log, stderr=log, check=False).returncode
    return target if code == 0 else None


def wanted_pictures(plan):
    """(name, caption, words of cornice-picture) of what can be shown; large surveys show a part."""
    is_stitched = records.has_succeeded(plan, "stitch", records.SURVEY)
    meshes = stages.meshes(plan)[:MOST_MESHES_DRAWN] if is_stitched else []
    tiles, points = [], 0
    for name in stages.readable(plan, "info"):
        points += plan["tiles"][name]["points"]
        if points > MOST_POINTS_DRAWN and tiles:
            break
        tiles.append(stages.tile_path(plan, name))
    has_lines = records.has_succeeded(plan, "flightlines", records.SURVEY)
    wanted = []
    if meshes:
        wanted += [("mesh", "The mesh, obliquely from above", ["--view", "oblique"] + meshes),
                   ("hillshade", "The mesh from straight above, lit from the north-west",
                    ["--view", "plan"] + meshes),
                   ("support", "Distance of the surface from the nearest measured point: what was "
                               "measured and what was bridged",
                    ["--view", "plan", "--colour", "support"] + meshes)]
    if tiles:
        wanted.append(("classes", "The points, coloured by class", ["--colour", "class"] + tiles))
    if tiles and has_lines:
        wanted.append(("lines", "The points, coloured by the flight line that was found for each",
                       ["--colour", "line", "--flightlines", stages.lines_path(plan)] + tiles))
    return wanted


# Of cornice-compare's pictures those that say most: (file, caption).
COMPARED = (("difference.png", "Height of the mesh above the elevation model, metres"),
            ("distance_B.png", "Distance of the mesh from the elevation model: walls show here"),
            ("overhangs_B.png", "Overhangs, which an elevation model cannot hold"))


def comparison(plan, found):
    """The pictures of the comparison, and where there is more of it."""
    record = found.get(("compare", records.SURVEY))
    if record is None or record["status"] != "done":
        return ""
    folder = stages.comparison_folder(plan)
    body = "".join(page.picture(os.path.join(folder, name), caption) for name, caption in COMPARED
                   if os.path.exists(os.path.join(folder, name)))
    return body + page.link("compare/index.html", "The whole comparison")


def summary(plan, reports):
    points = sum(entry["points"] for entry in plan["tiles"].values())
    area = sum((box[2] - box[0]) * (box[3] - box[1])
               for box in (entry["box"] for entry in plan["tiles"].values()))
    facts = [f"{len(plan['tiles'])} tiles, {points:,} points, {area / 1e6:.3f} km²",
             plan["crs"] or "no coordinate system", plan["version"]]
    for of_stage in reports.values():
        machine = next(iter(of_stage.values()))["machine"]
        facts.append(f"{machine['cpu']}, {machine['cores']} cores, "
                     f"{page.bytes_text(machine['memory_bytes'])}, {machine['os']}")
        break
    return page.paragraph("; ".join(facts), "soft")


def write(plan, failed):
    """Writes report.html into the output folder; returns its path."""
    found = {job: record for job in stages.jobs(plan)
             if (record := records.read(plan, *job)) is not None}
    reports = read_reports(plan, found)
    body = summary(plan, reports) + failure_section(plan, failed)
    body += "".join(page.paragraph(text, "warning") for text in plan["warnings"])
    for name, caption, words in wanted_pictures(plan):
        drawn = draw(plan, name, words)
        body += page.picture(drawn, caption) if drawn else page.paragraph(
            f"The picture \"{name}\" could not be drawn, see logs/pictures/{name}.log.", "warning")
    body += "<h2>What ran</h2>" + stage_table(plan, found, reports)
    for name, of_stage in reports.items():
        body += stage_section(name, of_stage)
        body += comparison(plan, found) if name == "compare" else ""
    target = records.path(plan, "report.html")
    with open(target + ".partial", "w", encoding="utf-8") as file:
        file.write(page.document(plan["config"].get("title", "Survey"), body))
    os.replace(target + ".partial", target)
    return target
