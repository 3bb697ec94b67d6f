#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes a survey through every stage: tiles in, one seamless mesh and a report out."""

import argparse
import errno
import fcntl
import math
import os
import shutil
import signal
import subprocess
import sys
import time

import configuration
import programs
import records
import report
import stages
import todo
import watch

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DONE, FAILED, USAGE = 0, 1, 2
DEM_ENDINGS = (".tif", ".tiff", ".asc")
TILE_ENDINGS = (".laz", ".las", ".las.zip")
NOT_ENDED = "did not end"
# What is wrong with single tiles before anything runs; the report has all of it.
MOST_WARNINGS_TOLD = 20
# More cells of the lattice than this for each point are too many.
CELLS_PER_POINT = 10
# With less than this no job can leave its record.
LEAST_FREE_BYTES = 64 * 1024
DISK_FULL = "the disk is full; free some space, the same command goes on from here"


class RunError(Exception):
    """Ends the program with an exit code and one line."""

    def __init__(self, code, text):
        super().__init__(text)
        self.code = code


def share_folder():
    """Where config/ lies: beside pipeline/ in the source tree and when installed."""
    return os.path.join(os.path.dirname(ROOT), "config")


def shipped_configs():
    folder = share_folder()
    names = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
    return [name for name in names if name.endswith(".yaml")]


def config_path(name):
    """The file that is named, or the one of this name that comes with the programs."""
    if os.path.exists(name) or os.path.dirname(name):
        return name
    if name in shipped_configs():
        return os.path.join(share_folder(), name)
    raise RunError(USAGE, f"{name}: no such file; those that come along are "
                          f"{', '.join(shipped_configs())}")


def program_version(folder):
    try:
        shown = subprocess.run([os.path.join(folder, "cornice-index"), "--version"],
                               capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise RunError(FAILED, f"{folder}: holds no cornice-index that runs ({error})") from error
    return shown.stdout.strip()


def index_survey(arguments, config, files, output):
    """Lays out the tiles; returns the index (docs/formats/survey.md)."""
    target = os.path.join(output, "survey.json")
    words = [os.path.join(arguments.programs, "cornice-index"), "-o", target, "--overwrite",
             "--no-progress", "--log-level", "error", "--halo-m", str(config.get("halo-m", 40)),
             "--step-m", str(config.get("step-m", 0.5))]
    if config.get("crs"):
        words += ["--crs", config["crs"]]
    done = subprocess.run(words + files, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        text = done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "no message"
        raise RunError(done.returncode, text.split("error: ", 1)[-1])
    return records.read_json(target)


def write_class_rules(config, output):
    """The normals' class rules as a file of their own; empty where the product's are to count."""
    rules = {key: value for key, value in config.get("normals", {}).items()
             if key in ("noise", "classes")}
    if "classes" not in rules:
        return ""
    target = os.path.join(output, "class-rules.yaml")
    # JSON is YAML.
    records.write_json(target, {"normals": rules})
    return target


def make_plan(arguments, config, files, output):
    survey = index_survey(arguments, config, files, output)
    plan = {
        "output": output,
        "programs": os.path.abspath(arguments.programs),
        "version": program_version(arguments.programs).replace("cornice-index", "cornice"),
        "config": config,
        "class_rules": write_class_rules(config, output),
        "crs": survey["crs"],
        "step_m": survey["step_m"],
        "halo_m": survey["halo_m"],
        "threads": max(1, arguments.threads or (os.cpu_count() or 1) // max(1, arguments.jobs)),
        "until": arguments.until,
        "stop_at_first_failure": arguments.stop_at_first_failure,
        "tiles": {tile["name"]: {"modified": todo.modified(tile["path"]), **{
            key: tile[key] for key in ("path", "points", "bytes", "box", "neighbours")}}
            for tile in survey["tiles"] if not tile["problem"]},
        "dem": {name: todo.modified(name) for name in configuration.files(
            arguments.config, "dem.files", config.get("dem", {}).get("files", []), DEM_ENDINGS)},
        "fill_dem": {name: todo.modified(name) for name in configuration.files(
            arguments.config, "fill-dem", config.get("fill-dem", []), DEM_ENDINGS)},
        "unusable": {tile["path"]: tile["problem"] for tile in survey["tiles"] if tile["problem"]},
        "warnings": survey["warnings"],
    }
    plan["warnings"] = plan["warnings"] + sparse_warning(plan)
    plan["fingerprints"] = todo.fingerprints(plan, plan["version"])
    return plan


def sparse_warning(plan):
    """Says so where the lattice is much finer than the points: all its cells cost time and memory."""
    points, cells = (sum(column) for column in zip(*stages.sizes(plan)))
    if points * CELLS_PER_POINT >= cells:
        return []
    step = plan["step_m"]
    density = points / (cells * step**2)
    wider = step * 2**round(math.log2(density**-0.5 / step))
    return [f"{density:.2g} points/m² are few for cells of {step:g} m: the mesh will be finer than what "
            f"was measured; with \"step-m: {wider:g}\" it takes far less time and memory"]


def snakemake_words(arguments, plan, output):
    words = ["snakemake", "--snakefile", os.path.join(ROOT, "Snakefile"), "--directory", output,
             "--config", f"plan={os.path.join(output, 'plan.json')}", "--nolock",
             "--profile", arguments.profile,
             # Choosing among ten thousand ready jobs by linear programming takes longer than they do.
             "--scheduler", "greedy"]
    total = arguments.memory * 1024 if arguments.memory else (
        os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20)
    if arguments.is_local:
        # A job alone may ask for all there is, whatever it was guessed to need.
        words += ["--cores", str(plan["threads"] * max(1, arguments.jobs)), "--resources",
                  f"mem_mb={int(0.9 * total)}"]
    elif arguments.jobs:
        words += ["--jobs", str(arguments.jobs)]
    return words if plan["stop_at_first_failure"] else words + ["--keep-going"]


def snakemake_environment(output):
    """With Snakemake's cache beside its other files: it ends where it cannot write in HOME."""
    return {**os.environ, "XDG_CACHE_HOME": os.path.join(output, ".snakemake")}


def hear_interrupts():
    """A shell starts what runs in the background deaf to SIGINT, which Snakemake stops by."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Interrupts:
    """Hands SIGINT and SIGTERM on to the process group that `group` names as soon as there is one.

    An exception of Python would come at any place, the showing of progress too, and leave the jobs
    running.
    """

    def __init__(self):
        self.came = False
        self.group = None

    def __enter__(self):
        self.before = {number: signal.signal(number, self.hear)
                       for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_):
        for number, handler in self.before.items():
            signal.signal(number, handler)

    def hear(self, _signal, _frame):
        self.came = True
        self.pass_on()

    def pass_on(self):
        if self.came and self.group is not None:
            try:
                os.killpg(self.group, signal.SIGINT)
            except ProcessLookupError:  # It has ended by itself.
                pass


def run_jobs(arguments, plan, output, left):
    """Runs Snakemake, showing progress; returns its exit code and whether it was interrupted."""
    words = snakemake_words(arguments, plan, output)
    log_path = os.path.join(output, "snakemake.log")
    view = watch.Watch(plan, left, max(1, arguments.jobs))
    with open(log_path, "w", encoding="utf-8") as log, Interrupts() as interrupts:
        try:
            process = subprocess.Popen(words, stdout=log, stderr=subprocess.STDOUT,
                                       start_new_session=True, preexec_fn=hear_interrupts,
                                       env=snakemake_environment(output))
        except FileNotFoundError as error:
            raise RunError(FAILED, "snakemake: is not installed; run scripts/setup, or install the "
                                   "package snakemake") from error
        interrupts.group = process.pid
        interrupts.pass_on()
        while True:
            try:
                code = process.wait(timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                view.show(arguments.no_progress)
        # Its number may soon be another's.
        interrupts.group = None
        view.finish()
    return code, interrupts.came


def failures(plan):
    """Every job that did not succeed, in order: (tile, stage, message)."""
    listed = []
    for stage, tile in stages.jobs(plan):
        record = records.read(plan, stage, tile)
        if record is None:
            listed.append((tile, stage, NOT_ENDED))
        elif record["status"] == "failed":
            listed.append((tile, stage, record["message"]))
    return listed


def say(text):
    print(f"cornice-run: {text}", file=sys.stderr, flush=True)


def survey_text(plan):
    count = len(plan["tiles"])
    points = sum(entry["points"] for entry in plan["tiles"].values())
    return (f"{count:,} tile{'' if count == 1 else 's'}, {points:,} points, "
            f"{plan['crs'] or 'no coordinate system'}")


def tell_start(plan, left):
    """What there is to do, and what is wrong with the survey, before hours are spent on it."""
    jobs = len(stages.jobs(plan))
    count = f"{len(left):,} of {jobs:,}" if len(left) < jobs else f"{jobs:,}"
    say(f"{survey_text(plan)}: {count} jobs to do")
    texts = [f"{name}: {problem}; the other tiles go on without it"
             for name, problem in plan["unusable"].items()] + plan["warnings"]
    for text in texts[:MOST_WARNINGS_TOLD]:
        say(f"warning: {text}")
    if len(texts) > MOST_WARNINGS_TOLD:
        say(f"warning: and {len(texts) - MOST_WARNINGS_TOLD:,} more, see the report")


def tell_faults(plan):
    """Where the mesh is not seamless."""
    target = records.report_path(plan, "stitch", records.SURVEY)
    if records.has_succeeded(plan, "stitch", records.SURVEY) and os.path.exists(target):
        for text in records.read_json(target)["warnings"]:
            say(f"warning: stitch: {text}")


def tell_end(plan, failed, code, log_path):
    for name, problem in plan["unusable"].items():
        say(f"error: {name}: {problem}")
    shown = [entry for entry in failed if entry[2] != NOT_ENDED]
    for tile, stage, message in shown:
        say(f"error: {records.label(plan, tile)}: {stage}: {message} "
            f"(log: {records.log_path(plan, stage, tile)})")
    if code != 0 and not shown:
        full = shutil.disk_usage(plan["output"]).free < LEAST_FREE_BYTES
        say(f"error: {plan['output']}: {DISK_FULL}" if full else
            f"error: the workflow ended early, see {log_path}")


def tell_todo(plan, left):
    """What a run would do."""
    print(survey_text(plan))
    for text in plan["warnings"]:
        print(f"warning: {text}")
    for name, problem in plan["unusable"].items():
        print(f"left out: {name}: {problem}")
    for stage, count in todo.counts(left).items():
        of_stage = len(stages.tiles_of(plan, stages.STAGES[stage]))
        print(f"{stage}: {count} of {of_stage}")
    if not left:
        print("nothing to do")


def locked(output):
    """Holds the output folder for this run; the lock goes with the process, however that ends."""
    lock = open(os.path.join(output, ".lock"), "w", encoding="utf-8")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise RunError(FAILED, f"{output}: another cornice run works there") from error
    return lock


def run(arguments):
    arguments.config = config_path(arguments.config)
    config = configuration.read(arguments.config, os.path.join(share_folder(),
                                                               "config.schema.json"))
    patterns = [os.path.abspath(name) for name in arguments.tiles] or config.get("tiles", [])
    if arguments.until and not stages.STAGES[arguments.until].is_wanted(config):
        raise RunError(USAGE, f"--until: {arguments.until}: {arguments.config} does not ask for it")
    if not patterns:
        raise RunError(USAGE, f"{arguments.config}: tiles: is missing; say it there or behind the "
                              "configuration")
    files = configuration.files(arguments.config, "tiles", patterns, TILE_ENDINGS)
    folder = os.path.dirname(os.path.abspath(arguments.config))
    output = os.path.abspath(arguments.output or os.path.join(folder, config.get("output", "")))
    if not arguments.output and not config.get("output"):
        raise RunError(USAGE, f"{arguments.config}: output: is missing; say it there or by -o")
    os.makedirs(output, exist_ok=True)
    lock = locked(output)
    plan = make_plan(arguments, config, files, output)
    left, _ = todo.find(plan)
    if arguments.dry_run:
        tell_todo(plan, left)
        return DONE
    records.write_json(os.path.join(output, "plan.json"), plan)
    todo.forget(plan, left)
    began = time.time()
    if left:
        tell_start(plan, left)
    code, interrupted = run_jobs(arguments, plan, output, left) if left else (DONE, False)
    failed = failures(plan)
    if interrupted:
        say("stopped; the same command goes on from here")
        return 128 + signal.SIGINT
    tell_end(plan, failed, code, os.path.join(output, "snakemake.log"))
    tell_faults(plan)
    if left:
        say(f"jobs ended after {watch.duration_text(time.time() - began)}; drawing the report")
    page = report.write(plan, failed)
    say(f"report: {page}")
    for name, result in (("stitch", f"mesh: {stages.mesh_folder(plan)}"),
                         ("hlod", f"hierarchy: {stages.hierarchy_path(plan)}"),
                         ("dem_hlod", "hierarchy of the elevation model: "
                                      f"{stages.dem_hierarchy_path(plan)}"),
                         ("compare", f"comparison: {stages.comparison_folder(plan)}/index.html")):
        if (name, records.SURVEY) in stages.jobs(plan) and records.has_succeeded(
                plan, name, records.SURVEY):
            say(result)
    lock.close()
    return FAILED if code != 0 or failed or plan["unusable"] else DONE


def parse(words):
    parser = argparse.ArgumentParser(prog="cornice-run", description=__doc__,
                                     epilog="A run that was stopped, or had failures, goes on where "
                                            "it was: give the same command again.")
    parser.add_argument("config", metavar="CONFIG",
                        help=f"YAML file, or one that comes along: {', '.join(shipped_configs())}")
    parser.add_argument("tiles", nargs="*", metavar="TILE", default=[],
                        help="files, folders or patterns, instead of those that CONFIG names")
    parser.add_argument("-o", "--output", metavar="FOLDER",
                        help="for the results, instead of the one that CONFIG names")
    parser.add_argument("-n", "--dry-run", action="store_true", help="says what would be done")
    parser.add_argument("--until", choices=stages.STAGES, default="", metavar="STAGE",
                        help="last stage to run: " + ", ".join(stages.STAGES))
    parser.add_argument("--profile", default="local", metavar="NAME",
                        help="local, slurm, or the folder of a Snakemake profile (default local)")
    parser.add_argument("--jobs", type=int, default=0, metavar="N",
                        help="jobs at once (default: 1 here, the profile's elsewhere)")
    parser.add_argument("--threads", type=int, default=0, metavar="N",
                        help="of each job (default: all cores shared by the jobs)")
    parser.add_argument("--memory", type=float, default=0, metavar="GiB",
                        help="that jobs at once may use here (default: the machine's)")
    parser.add_argument("--stop-at-first-failure", action="store_true",
                        help="stops instead of going on with the other tiles")
    parser.add_argument("--no-progress", action="store_true", help="shows no progress")
    parser.add_argument("--version", action="store_true", help="shows the version")
    parser.add_argument("--programs", default=os.path.dirname(os.path.realpath(sys.argv[0])),
                        help=argparse.SUPPRESS)
    if "--version" in words:
        known, _ = parser.parse_known_args(words + ["-"])
        print(program_version(known.programs).replace("cornice-index", "cornice-run"))
        sys.exit(DONE)
    arguments = parser.parse_args(words)
    built_in = os.path.join(ROOT, "profiles", arguments.profile)
    arguments.is_local = arguments.profile == "local"
    if os.path.isdir(built_in):
        arguments.profile = built_in
    elif not os.path.isdir(arguments.profile):
        raise RunError(USAGE, f"--profile: {arguments.profile}: is neither local, slurm nor a folder")
    return arguments


def raise_interrupt(_signal, _frame):
    raise KeyboardInterrupt


def main():
    signal.signal(signal.SIGTERM, raise_interrupt)
    programs.allow_long_command_lines()
    try:
        return run(parse(sys.argv[1:]))
    except configuration.ConfigError as error:
        say(f"error: {error}")
        return USAGE
    except RunError as error:
        say(f"error: {error}")
        return error.code
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        say(f"error: {where}{DISK_FULL if error.errno == errno.ENOSPC else error.strerror.lower()}")
        return FAILED
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


if __name__ == "__main__":
    sys.exit(main())
