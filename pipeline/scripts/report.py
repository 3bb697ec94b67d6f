# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a survey's run: one HTML page that needs no other file."""

import os
import subprocess

import figures
import page
import records
import stages

# What a picture shows at most; a larger survey shows its first tiles.
MOST_MESHES_DRAWN = 36
MOST_POINTS_DRAWN = 30_000_000
# And of lines about what failed.
MOST_LINES = 500


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
    head = [("stage", False), ("jobs", True), ("not done", True), ("warnings", True),
            ("seconds", True), ("longest", True), ("CPU seconds", True), ("peak memory", True)]

    def row(title, count, warnings, done):
        seconds = [record["seconds"] for record in done]
        return [title, count, count - len(done), warnings, page.seconds_text(sum(seconds)),
                page.seconds_text(max(seconds, default=0.0)),
                page.seconds_text(sum(record["cpu_seconds"] for record in done)),
                page.bytes_text(max((record["peak_memory_bytes"] for record in done), default=0))]

    done = {}
    for (stage, _), record in found.items():
        if record["status"] == "done":
            done.setdefault(stage, []).append(record)
    rows = [row(stage.name, len(stages.tiles_of(plan, stage)),
                sum(len(report["warnings"]) for report in reports.get(stage.name, {}).values()),
                done.get(stage.name, [])) for stage in stages.active(plan)]
    rows.append(row("all", sum(entry[1] for entry in rows), sum(entry[3] for entry in rows),
                    [record for of_stage in done.values() for record in of_stage]))
    return page.table(head, rows)


def stage_section(name, reports):
    parts = [f"<h2>{page.escape(stages.STAGES[name].title)}</h2>"]
    for text, tiles in figures.warnings(reports):
        like = f" (and like it on {len(tiles) - 1} more tiles)" if len(tiles) > 1 else ""
        parts.append(page.paragraph(text + like, "warning"))
    parts.append(page.folded("Figures", figures.table(reports), is_open=True))
    steps = {}
    for report in reports.values():
        for step in report["steps"]:
            steps.setdefault(step["name"], []).append(step["seconds"])
    if steps:
        parts.append(page.folded("Steps", page.table(
            [("step", False), ("seconds, all tiles", True), ("longest", True)],
            [[step, page.seconds_text(sum(times)), page.seconds_text(max(times))]
             for step, times in steps.items()])))
    first = next(iter(reports.values()))
    parts.append(page.folded("Parameters of the first job", page.table(
        [("parameter", False), ("value", False)],
        [[key, page.list_text(value) if isinstance(value, list) else value]
         for key, value in first["parameters"].items()])))
    return "".join(parts)


def failure_section(plan, failed):
    lines = [f"{name}: {problem}" for name, problem in plan["unusable"].items()]
    for tile, stage, message in failed:
        lines.append(f"{records.label(plan, tile)}: {stage}: {message}")
    if not lines:
        return ""
    title = f"<h2>What is not whole ({len(lines)})</h2>"
    more = len(lines) - MOST_LINES
    if more > 0:
        lines[MOST_LINES:] = [f"and {more} more: see the folder state"]
    return title + "".join(page.paragraph(line, "failure") for line in lines)


def draw(plan, name, words):
    """One picture by cornice-picture; its path, or None with a note in the log."""
    target = records.path(plan, "pictures", name + ".png")
    log_path = records.log_path(plan, "pictures", name)
    for file_path in (target, log_path):
        os.makedirs(os.path.dirname(file_path), exist_ok=True)
    command = [os.path.join(plan["programs"], "cornice-picture")] + words + [
        "-o", target, "--overwrite", "--no-progress"]
    with open(log_path, "w", encoding="utf-8") as log:
        code = subprocess.run(command, stdout=log, stderr=log, check=False).returncode
    return target if code == 0 else None


# What cornice-viewer draws of the levels of detail: (name, caption, --view, words). The first of a
# view looks for its camera, which takes longer than the picture; the others take the same.
VIEWS = (
    ("overview", "The mesh as cornice-viewer shows it: snow, rock, scree and grass by slope and height",
     "overview", []),
    ("steepest", "Its steepest part", "steepest", []),
    ("slope", "The same by slope", "steepest", ["--shading", "slope", "--legend"]),
    ("levels", "The triangles that are drawn where the surface may be off by 4 pixels, a colour for each "
               "level of detail: the farther away, the coarser",
     "steepest", ["--shading", "level", "--edges", "--error-pixels", "4", "--legend"]))
# A view takes seconds; one that takes this long is left out.
MOST_VIEW_SECONDS = 300
# Enough for pictures of this size, whatever the survey's.
VIEW_WORDS = ["--headless", "--size", "1200x750", "--gpu-memory-mib", "384", "--cache-mib", "256",
              "--triangle-budget-m", "4"]


def draw_view(plan, name, words):
    """One picture by cornice-viewer: (its path, "") or (None, why there is none)."""
    target = records.path(plan, "pictures", name + ".jpg")
    log_path = records.log_path(plan, "pictures", name)
    for file_path in (target, log_path):
        os.makedirs(os.path.dirname(file_path), exist_ok=True)
    command = [os.path.join(plan["programs"], "cornice-viewer"), stages.hierarchy_path(plan)]
    command += VIEW_WORDS + words + ["-o", target, "--overwrite", "--no-progress"]
    with open(log_path, "w", encoding="utf-8") as log:
        try:
            code = subprocess.run(command, stdout=log, stderr=log, check=False,
                                  timeout=MOST_VIEW_SECONDS).returncode
        except OSError as error:
            return None, f"cornice-viewer does not start ({error.strerror})"
        except subprocess.TimeoutExpired:
            return None, f"cornice-viewer took longer than {MOST_VIEW_SECONDS} s"
    if code == 0:
        return target, ""
    with open(log_path, encoding="utf-8", errors="replace") as log:
        lines = [line.strip() for line in log if line.strip()]
    return None, lines[-1].split("error: ", 1)[-1] if lines else f"cornice-viewer ended with {code}"


def views(plan):
    """The pictures of the viewer, or one line that says why there are none: not every machine has
    OpenGL, and nothing else wants it."""
    if not records.has_succeeded(plan, "hlod", records.SURVEY):
        return ""
    parts, problems, has_camera = [], [], set()
    for name, caption, view, words in VIEWS:
        # The light of the view, and its camera where a picture before this one has found it.
        camera = records.path(plan, "pictures", view + ".json")
        words = ["--view", view, "--camera" if view in has_camera else "--save-camera", camera] + words
        drawn, problem = draw_view(plan, name, words)
        if drawn is not None:
            has_camera.add(view)
            parts.append(page.picture(drawn, caption))
            continue
        problems.append(problem)
        parts.append(page.paragraph(f"The picture \"{name}\" is missing: {problem}.", "warning"))
        if len(problems) == len({view for _, _, view, _ in VIEWS}) and not has_camera:
            break
    if not has_camera:
        return page.paragraph(f"No pictures by cornice-viewer: {problems[0]}.", "soft")
    return "".join(parts)


def part_of(shown, everything):
    return "" if len(shown) == len(everything) else (
        f" (the first {len(shown)} of {len(everything)} tiles)")


def mesh_pictures(plan):
    """(name, caption, words of cornice-picture)"""
    if not records.has_succeeded(plan, "stitch", records.SURVEY):
        return []
    everything = stages.meshes_in(stages.mesh_folder(plan))
    meshes = everything[:MOST_MESHES_DRAWN]
    if not meshes:
        return []
    part = part_of(meshes, everything)
    return [
        ("mesh", "The mesh, obliquely from above; red is its underside" + part,
         ["--view", "oblique"] + meshes),
        ("hillshade", "The mesh from straight above, north up, lit from the north-west" + part,
         ["--view", "plan"] + meshes),
        ("support", "How far the surface is from the nearest measured point: grey up to half a metre, "
                    "yellow to red up to ten metres and beyond, where a gap was bridged" + part,
         ["--view", "plan", "--colour", "support"] + meshes)]


def point_pictures(plan):
    everything = stages.readable(plan, "info")
    tiles, points = [], 0
    for name in everything:
        points += plan["tiles"][name]["points"]
        if points > MOST_POINTS_DRAWN and tiles:
            break
        tiles.append(stages.tile_path(plan, name))
    if not tiles:
        return []
    part = part_of(tiles, everything)
    wanted = [("classes", "The points by class: ground brown, vegetation green, buildings red, water "
                          "blue, bridges yellow, others grey" + part, ["--colour", "class"] + tiles)]
    if records.has_succeeded(plan, "flightlines", records.SURVEY):
        wanted.append(("lines", "The points, coloured by the flight line that was found for each" + part,
                       ["--colour", "line", "--flightlines", stages.lines_path(plan)] + tiles))
    return wanted


# Of cornice-compare's pictures those that say most: (file, caption).
COMPARED = (("difference.png", "Height of the mesh above the elevation model, metres"),
            ("distance_b.png", "Distance of the mesh from the elevation model: walls show here"),
            ("overhangs_b.png", "Overhangs, which an elevation model cannot hold"))


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
    facts = [f"{len(plan['tiles']):,} tiles, {points:,} points, {area / 1e6:,.3f} km²",
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
    pictures = views(plan)
    for name, caption, words in mesh_pictures(plan) + point_pictures(plan):
        drawn = draw(plan, name, words)
        pictures += page.picture(drawn, caption) if drawn else page.paragraph(
            f"The picture \"{name}\" could not be drawn, see logs/pictures/{name}.log.", "warning")
    body += figures.results(reports) + pictures
    body += "<h2>What ran</h2>" + stage_table(plan, found, reports)
    for name, of_stage in reports.items():
        body += stage_section(name, of_stage)
        body += comparison(plan, found) if name == "compare" else ""
    target = records.path(plan, "report.html")
    records.write_text(target, page.document(plan["config"].get("title", "Survey"), body))
    return target
