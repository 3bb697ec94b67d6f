# SPDX-License-Identifier: GPL-3.0-or-later
"""The stages of a survey: what each one needs, runs and leaves behind.

This is the one place that knows command lines and file names; the Snakefile knows the order of jobs
only. A job is a stage and a tile, or a stage and the survey (tile "survey").
"""

import dataclasses
import os
from typing import Callable

from records import SURVEY, has_succeeded, path, succeeded

# Beyond the halo, so that the normals in it have all their neighbours (stages/normals/README.md).
NORMALS_REACH_M = 5.0
# Keys of the section "poisson" that belong to its second step.
EXTRACT_KEYS = ("support-cap-m",)
MOST_HLOD_MB = 8192


@dataclasses.dataclass(frozen=True)
class Cost:
    """What a job takes: for its points, and for the cells of the lattice under its ground. A cell is
    `step-m` wide; sparse points on much ground cost by the cell. Measured on 1 km² of mountain with
    20 points/m² and on 1 km² of plain with 0.25."""

    bytes_per_point: float  # peak memory, half as much again as was measured; for the scheduler
    bytes_per_cell: float
    seconds_per_million_points: float  # on one core; a first guess for the time left
    seconds_per_million_cells: float

    def memory(self, points, cells):
        return self.bytes_per_point * points + self.bytes_per_cell * cells

    def seconds(self, points, cells):
        return 0.2 + (self.seconds_per_million_points * points +
                      self.seconds_per_million_cells * cells) / 1e6


@dataclasses.dataclass(frozen=True)
class Stage:
    """One kind of job."""

    name: str
    title: str  # of its section in the report
    program: str  # cornice-PROGRAM runs it; the configuration's section of this name is its options
    per: str  # "tile", "region" or "survey": what there is one job for
    # (stage, scope): "own" the same tile's job, "around" also its neighbours', "all" every tile's,
    # "each" every region's, "survey" the survey's one. All of them must have ended; "own", "each" and
    # "survey" must have succeeded, and one at least of "all".
    needs: tuple
    command: Callable  # (plan, tile) -> list of words, without threads, memory and report
    outputs: Callable  # (plan, tile) -> paths that the job leaves
    cost: Cost
    is_wanted: Callable = lambda config: True
    reads: str = ""  # entry of the plan with files, not tiles, that it reads: {path: modified}


def flags(plan, section, skip=(), only=None):
    """A section of the configuration as words of a command line."""
    words = []
    for key, value in plan["config"].get(section, {}).items():
        if key in skip or (only is not None and key not in only):
            continue
        if isinstance(value, bool):
            words.append(f"--{key}" if value else f"--no-{key}")
        elif isinstance(value, list):
            words += [f"--{key}", ",".join(str(entry) for entry in value)]
        else:
            words += [f"--{key}", str(value)]
    return words


def crs_flags(plan):
    crs = plan["config"].get("crs", "")
    return ["--crs", crs] if crs else []


def fill_flags(plan):
    return ["--fill-dem"] + list(plan["fill_dem"]) if plan["fill_dem"] else []


def tile_path(plan, tile):
    return plan["tiles"][tile]["path"]


def box_text(plan, tile):
    return ",".join(repr(edge) for edge in plan["tiles"][tile]["box"])


def readable_around(plan, stage, tile):
    """Neighbours whose job of `stage` has succeeded, in the order of their names."""
    return succeeded(plan, stage, plan["tiles"][tile]["neighbours"])


def readable(plan, stage):
    return succeeded(plan, stage, plan["tiles"])


# Names of files ----------------------------------------------------------------------------------


def lines_path(plan):
    return path(plan, "lines.gpkg")


def points_path(plan, tile):
    return path(plan, "points", tile + ".ply")


def field_path(plan, tile):
    return path(plan, "field", tile + ".field")


def band_path(plan, tile):
    return path(plan, "field", tile + ".band")


def surface_path(plan, tile):
    return path(plan, "surface", tile + ".ply")


def trimmed_path(plan, tile):
    return path(plan, "trimmed", tile + ".ply")


def remeshed_path(plan, tile):
    return path(plan, "remeshed", tile + ".ply")


def mesh_folder(plan):
    return path(plan, "mesh")


def hierarchy_path(plan):
    return path(plan, "survey.hlod")


def dem_folder(plan):
    return path(plan, "dem")


def dem_hierarchy_path(plan):
    return path(plan, "dem.hlod")


def comparison_folder(plan):
    return path(plan, "compare")


# Commands ----------------------------------------------------------------------------------------


def info_command(plan, tile):
    return ["cornice-info", tile_path(plan, tile), "--json"] + crs_flags(plan)


def flightlines_command(plan, _):
    tiles = [tile_path(plan, name) for name in readable(plan, "info")]
    return (["cornice-flightlines"] + tiles + ["-o", lines_path(plan)] + crs_flags(plan) +
            flags(plan, "flightlines"))


def normals_command(plan, tile):
    around = [tile_path(plan, name) for name in readable_around(plan, "info", tile)]
    words = ["cornice-normals", tile_path(plan, tile), "--flightlines", lines_path(plan),
             "-o", points_path(plan, tile), "--keep-halo", "--halo-m",
             str(plan["halo_m"] + NORMALS_REACH_M)]
    if around:
        words += ["--neighbours"] + around
    if plan["class_rules"]:
        words += ["--config", plan["class_rules"]]
    elif plan["config"].get("product", "auto") != "auto":
        words += ["--product", plan["config"]["product"]]
    return words + crs_flags(plan) + flags(plan, "normals", skip=("noise", "classes"))


def solve_command(plan, tile):
    return (["cornice-poisson", "solve", points_path(plan, tile), "-o", field_path(plan, tile),
             "--tile", box_text(plan, tile), "--step-m", str(plan["step_m"]),
             "--halo-m", str(plan["halo_m"])] + fill_flags(plan) +
            flags(plan, "poisson", skip=EXTRACT_KEYS))


def extract_command(plan, tile):
    around = [band_path(plan, name) for name in readable_around(plan, "solve", tile)]
    words = ["cornice-poisson", "extract", field_path(plan, tile), "--points",
             points_path(plan, tile), "-o", surface_path(plan, tile)]
    words += flags(plan, "poisson", only=EXTRACT_KEYS)
    return words + (["--neighbours"] + around if around else [])


def trim_command(plan, tile):
    return (["cornice-trim", surface_path(plan, tile), "-o", trimmed_path(plan, tile)] +
            fill_flags(plan) + flags(plan, "trim"))


def remesh_command(plan, tile):
    return (["cornice-remesh", trimmed_path(plan, tile), "-o", remeshed_path(plan, tile)] +
            flags(plan, "remesh"))


def stitch_command(plan, _):
    tiles = [remeshed_path(plan, name) for name in readable(plan, "remesh")]
    return ["cornice-stitch"] + tiles + ["-o", mesh_folder(plan)] + flags(plan, "stitch")


def meshes_in(folder):
    return [os.path.join(folder, name) for name in sorted(os.listdir(folder))
            if name.endswith(".ply")]


def regions_of(config):
    return config.get("hlod", {}).get("regions", 1)


def region_names(plan):
    count = regions_of(plan["config"])
    return [f"{number}-of-{count}" for number in range(1, count + 1)]


def region_path(plan, region):
    return path(plan, "regions", region)


def region_command(plan, region):
    return (["cornice-hlod", "build"] + meshes_in(mesh_folder(plan)) +
            ["-o", region_path(plan, region), "--region", region.replace("-of-", "/")] +
            flags(plan, "hlod", skip=("regions",)))


def hlod_command(plan, _):
    if regions_of(plan["config"]) > 1:
        return (["cornice-hlod", "build"] + [region_path(plan, name) for name in region_names(plan)] +
                ["--join", "-o", hierarchy_path(plan)])
    return (["cornice-hlod", "build"] + meshes_in(mesh_folder(plan)) +
            ["-o", hierarchy_path(plan)] + flags(plan, "hlod", skip=("regions",)))


def dem_command(plan, _):
    return (["cornice-dem"] + list(plan["dem"]) + ["-o", dem_folder(plan)] + crs_flags(plan) +
            flags(plan, "dem", skip=("files",)))


def dem_hlod_command(plan, _):
    """A raster has one height in each place: columns, whatever the cells of the mesh are."""
    return (["cornice-hlod", "build"] + meshes_in(dem_folder(plan)) +
            ["-o", dem_hierarchy_path(plan)] + flags(plan, "hlod", skip=("regions", "partition")))


def compare_command(plan, _):
    """The elevation model is the reference: what lies above it counts as positive."""
    listed = path(plan, "dem-files.txt")
    with open(listed, "w", encoding="utf-8") as file:
        file.write("\n".join(plan["dem"]) + "\n")
    return (["cornice-compare", listed, mesh_folder(plan), "-o", comparison_folder(plan)] +
            flags(plan, "compare"))


def makes_ply(config):
    return config.get("stitch", {}).get("format", "ply") == "ply"


STAGES = {stage.name: stage for stage in (
    Stage("info", "What is in the tiles", "info", "tile", (), info_command,
          lambda plan, tile: [], Cost(60, 0, 0.8, 0)),
    Stage("flightlines", "Flight lines", "flightlines", "survey", (("info", "all"),),
          flightlines_command, lambda plan, tile: [lines_path(plan)],
          Cost(10, 0, 0.6, 0)),
    Stage("normals", "Normals", "normals", "tile",
          (("info", "own"), ("info", "around"), ("flightlines", "survey")),
          normals_command, lambda plan, tile: [points_path(plan, tile)],
          Cost(130, 0, 2.0, 0)),
    Stage("solve", "Field around the surface", "poisson", "tile", (("normals", "own"),),
          solve_command, lambda plan, tile: [field_path(plan, tile), band_path(plan, tile)],
          Cost(190, 290, 2.0, 2.0), reads="fill_dem"),
    Stage("extract", "Surface", "poisson", "tile", (("solve", "own"), ("solve", "around")),
          extract_command, lambda plan, tile: [surface_path(plan, tile)],
          Cost(130, 240, 0.6, 1.6)),
    Stage("trim", "Trimming", "trim", "tile", (("extract", "own"),), trim_command,
          lambda plan, tile: [trimmed_path(plan, tile)], Cost(35, 340, 0.3, 1.1), reads="fill_dem"),
    Stage("remesh", "Remeshing", "remesh", "tile", (("trim", "own"),), remesh_command,
          lambda plan, tile: [remeshed_path(plan, tile)], Cost(75, 450, 5.0, 13.0)),
    Stage("stitch", "Stitching", "stitch", "survey", (("remesh", "all"),), stitch_command,
          lambda plan, tile: [mesh_folder(plan)], Cost(15, 20, 0.1, 0.3)),
    Stage("regions", "Regions of the levels of detail", "hlod", "region", (("stitch", "survey"),),
          region_command, lambda plan, region: [region_path(plan, region)], Cost(40, 60, 0.2, 0.5),
          lambda config: makes_ply(config) and regions_of(config) > 1),
    Stage("hlod", "Levels of detail", "hlod", "survey", (("stitch", "survey"), ("regions", "each")),
          hlod_command, lambda plan, tile: [hierarchy_path(plan)], Cost(20, 60, 0.2, 0.5), makes_ply),
    Stage("dem", "Elevation model", "dem", "survey", (), dem_command,
          lambda plan, tile: [dem_folder(plan)], Cost(30, 60, 0, 0.5),
          lambda config: "dem" in config, "dem"),
    Stage("dem_hlod", "Levels of detail of the elevation model", "hlod", "survey",
          (("dem", "survey"),), dem_hlod_command, lambda plan, tile: [dem_hierarchy_path(plan)],
          Cost(20, 60, 0.2, 0.5), lambda config: "dem" in config),
    Stage("compare", "Mesh against elevation model", "compare", "survey", (("stitch", "survey"),),
          compare_command, lambda plan, tile: [comparison_folder(plan)], Cost(60, 100, 0.5, 1.0),
          lambda config: "dem" in config and makes_ply(config), "dem"),
)}


def active(plan):
    """The stages that the configuration asks for up to plan["until"], in their order."""
    listed = []
    for stage in STAGES.values():
        if stage.is_wanted(plan["config"]):
            listed.append(stage)
        if stage.name == plan["until"]:
            break
    return listed


def chains(plan):
    """The stages in groups, each to be run by one job of the scheduler: a stage that waits for
    nothing but the one before on the same tile joins it. Ten thousand tiles are then thirty
    thousand jobs instead of sixty."""
    groups = []
    for stage in active(plan):
        if groups and stage.per == "tile" and stage.needs == ((groups[-1][-1].name, "own"),):
            groups[-1].append(stage)
        else:
            groups.append([stage])
    return groups


def tiles_of(plan, stage):
    """What a stage's jobs are about: tiles, regions or the survey."""
    return {"tile": plan["tiles"], "region": region_names(plan), "survey": [SURVEY]}[stage.per]


def jobs(plan):
    """Every job, in the order of the stages: (stage, tile)."""
    return [(stage.name, tile) for stage in active(plan) for tile in tiles_of(plan, stage)]


def upstream(plan, stage, tile):
    """The jobs that must have ended before: (stage, tile, must have succeeded)."""
    listed = []
    for name, scope in STAGES[stage].needs:
        if not STAGES[name].is_wanted(plan["config"]):
            continue
        if scope == "own":
            listed.append((name, tile, True))
        elif scope == "around":
            listed += [(name, other, False) for other in plan["tiles"][tile]["neighbours"]]
        else:
            listed += [(name, other, scope != "all") for other in tiles_of(plan, STAGES[name])]
    return listed


def size_of(plan, tile, margin_m=0.0):
    """(points, cells) of a tile and a margin around it."""
    entry = plan["tiles"][tile]
    west, south, east, north = entry["box"]
    width, height = max(east - west, 1.0), max(north - south, 1.0)
    grown = (width + 2.0 * margin_m) * (height + 2.0 * margin_m) / (width * height)
    return (entry["points"] * min(grown, 1.0 + len(entry["neighbours"])),
            grown * width * height / plan["step_m"]**2)


def sizes(plan):
    return [size_of(plan, tile) for tile in plan["tiles"]]


def whole_size(plan, stage):
    """(points, cells) that a job of the survey or of a region takes its time for."""
    share = 1.0 / regions_of(plan["config"]) if STAGES[stage].per == "region" else 1.0
    return tuple(share * sum(column) for column in zip(*sizes(plan)))


def memory_mb(plan, stage, tile):
    """What the scheduler keeps free for a job. A job of the survey holds a tile at a time; building
    levels of detail takes what there is, and goes to the disk beyond."""
    cost = STAGES[stage].cost
    if STAGES[stage].per == "tile":
        needed = cost.memory(*size_of(plan, tile, plan["halo_m"]))
    elif STAGES[stage].program == "hlod":
        needed = min(cost.memory(*whole_size(plan, stage)), MOST_HLOD_MB * 2**20)
    else:
        needed = max((cost.memory(*size) for size in sizes(plan)), default=0)
    return 300 + int(needed / 2**20)


def expected_seconds(plan, stage, tile):
    """A first guess of a job's time on one core."""
    if STAGES[stage].per == "tile":
        return STAGES[stage].cost.seconds(*size_of(plan, tile, plan["halo_m"]))
    return STAGES[stage].cost.seconds(*whole_size(plan, stage))


def expected_times(plan):
    """{(stage, tile): expected_seconds} of all jobs"""
    times = {}
    for stage in active(plan):
        shared = None if stage.per == "tile" else expected_seconds(plan, stage.name, SURVEY)
        for tile in tiles_of(plan, stage):
            times[stage.name, tile] = (expected_seconds(plan, stage.name, tile)
                                       if shared is None else shared)
    return times


def runtime_minutes(plan, stage, tile):
    """A generous limit for a scheduler: ten times the expected time and ten minutes."""
    return 10 + int(expected_seconds(plan, stage, tile) / 6.0)
