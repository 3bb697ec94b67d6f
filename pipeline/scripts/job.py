#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one job of a plan and records what became of it.

The record (state/STAGE/TILE.json) is what the workflow waits for. A job that fails writes one, too,
and ends with 0, so that one bad tile does not stop the others; its dependants skip themselves, its
neighbours go on as if the survey ended there. With "stop_at_first_failure" in the plan a failed job
ends with its own exit code instead.
"""

import argparse
import json
import os
import subprocess
import sys
import time

import stages


def write_whole(target, text):
    os.makedirs(os.path.dirname(target), exist_ok=True)
    partial = f"{target}.{os.getpid()}.partial"
    with open(partial, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(partial, target)


def failed_before(plan, stage, tile):
    """The upstream job without which this one cannot run, or None."""
    for name, other, must in stages.upstream(plan, stage, tile):
        if must and not stages.has_succeeded(plan, name, other):
            return name, other
    if stage in ("flightlines", "stitch"):
        source = "info" if stage == "flightlines" else "remesh"
        if not stages.readable(plan, source):
            return source, next(iter(plan["tiles"]))
    return None


def last_error(log_path, tool):
    """The line of the log that says why the tool failed."""
    with open(log_path, encoding="utf-8", errors="replace") as log:
        lines = [line.strip() for line in log if line.strip()]
    errors = [line for line in lines if f"{tool}: error: " in line]
    if errors:
        return errors[-1].split("error: ", 1)[1]
    return lines[-1] if lines else "no message"


def problem_in_info(json_path):
    """Why a tile that cornice-info could open is not whole; empty where it is."""
    with open(json_path, encoding="utf-8") as file:
        entry = json.load(file)["files"][0]
    if "error" in entry:
        return entry["error"]
    if not entry.get("complete", True):
        return next((defect["text"] for defect in entry["defects"]), "is not whole")
    return "" if entry.get("points", 0) > 0 else "has no points"


def run_tool(plan, stage, tile, threads, log_path):
    """Runs the stage's program; returns its exit code (128 + n: ended by signal n)."""
    words = stages.STAGES[stage].command(plan, tile)
    words[0] = os.path.join(plan["programs"], words[0])
    words += ["--threads", str(threads), "--no-progress", "--overwrite", "--report",
              stages.path(plan, "reports", stage, tile + ".json")]
    for output in stages.STAGES[stage].outputs(plan, tile):
        os.makedirs(os.path.dirname(output), exist_ok=True)
    os.makedirs(stages.path(plan, "reports", stage), exist_ok=True)
    with open(log_path, "w", encoding="utf-8") as log:
        log.write(" ".join(words) + "\n")
        log.flush()
        out = log
        if stage == "info":
            os.makedirs(stages.path(plan, "info"), exist_ok=True)
            out = open(stages.path(plan, "info", tile + ".json"), "w", encoding="utf-8")
        try:
            code = subprocess.run(words, stdout=out, stderr=log, check=False).returncode
        finally:
            if out is not log:
                out.close()
    return 128 - code if code < 0 else code


def message_of(plan, stage, tile, code, log_path):
    if code in (128 + 9, 137):
        return "was killed (signal 9); was there memory enough?"
    if code > 128:
        return f"was stopped by signal {code - 128}"
    message = last_error(log_path, "cornice-" + {"solve": "poisson", "extract": "poisson"}.get(
        stage, stage))
    # The tile is named beside the message.
    for known in (stages.tile_path(plan, tile),) if tile != stages.SURVEY else ():
        message = message.removeprefix(known + ": ")
    return message


def run(plan, stage, tile, threads):
    started = time.time()
    outcome = {"stage": stage, "tile": tile, "fingerprint": plan["fingerprints"][stage][tile]}
    missing = failed_before(plan, stage, tile)
    log_path = stages.path(plan, "logs", stage, tile + ".log")
    if missing:
        outcome.update(status="skipped", exit_code=0, message=f"needs {missing[0]} of {missing[1]}")
    else:
        os.makedirs(os.path.dirname(log_path), exist_ok=True)
        code = run_tool(plan, stage, tile, threads, log_path)
        message = "" if code == 0 else message_of(plan, stage, tile, code, log_path)
        if stage == "info" and code == 0:
            message = problem_in_info(stages.path(plan, "info", tile + ".json"))
            code = 3 if message else 0
        # Stopped from outside: nothing became of it, the next run does it again.
        if code in (128 + 2, 128 + 15):
            return code
        outcome.update(status="failed" if code else "done", exit_code=code, message=message)
    outcome["seconds"] = round(time.time() - started, 3)
    if outcome["status"] == "failed" and plan["stop_at_first_failure"]:
        print(f"{tile}: {stage}: {outcome['message']}", file=sys.stderr)
        return outcome["exit_code"]
    write_whole(stages.outcome_path(plan, stage, tile), json.dumps(outcome, indent=1) + "\n")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("plan", metavar="PLAN.json")
    parser.add_argument("stage", choices=stages.STAGES)
    parser.add_argument("tile", help="its name, or \"survey\"")
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    with open(arguments.plan, encoding="utf-8") as file:
        plan = json.load(file)
    try:
        return run(plan, arguments.stage, arguments.tile, arguments.threads)
    except KeyboardInterrupt:
        return 128 + 2


if __name__ == "__main__":
    sys.exit(main())
