#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs one job of a plan, or a chain of them on one tile, and records what became of each.

The record (state/STAGE/TILE.json) is what the workflow waits for. A job that fails writes one, too,
and ends with 0, so that one bad tile does not stop the others; its dependants skip themselves, its
neighbours go on as if the survey ended there. With "stop_at_first_failure" in the plan a failed job
ends with its own exit code instead.
"""

import argparse
import json
import os
import shlex
import sys
import time
import uuid

import programs
import records
import stages

BAD_INPUT = 3


def failed_before(plan, stage, tile):
    """The upstream job without which this one cannot run, or None."""
    for name, other, must in stages.upstream(plan, stage, tile):
        if must and not records.has_succeeded(plan, name, other):
            return name, other
    for name, scope in stages.STAGES[stage].needs:
        if scope == "all" and not stages.readable(plan, name):
            return name, next(iter(plan["tiles"]))
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
    """Runs the stage's program; returns its exit code and what it used."""
    words = stages.STAGES[stage].command(plan, tile)
    words[0] = os.path.join(plan["programs"], words[0])
    report = records.report_path(plan, stage, tile)
    words += ["--threads", str(threads), "--no-progress", "--overwrite", "--report", report]
    for target in stages.STAGES[stage].outputs(plan, tile) + [report, log_path]:
        os.makedirs(os.path.dirname(target), exist_ok=True)
    with open(log_path, "w", encoding="utf-8") as log:
        log.write(shlex.join(words) + "\n")
        log.flush()
        out = log
        if stage == "info":
            os.makedirs(records.path(plan, "info"), exist_ok=True)
            out = open(records.path(plan, "info", tile + ".json"), "w", encoding="utf-8")
        try:
            return programs.run_measured(words, stdout=out, stderr=log)
        finally:
            if out is not log:
                out.close()


def message_of(plan, stage, tile, code, log_path):
    if code in (128 + 9, 137):
        return "was killed (signal 9); was there memory enough?"
    if code > 128:
        return f"was stopped by signal {code - 128}"
    if stage == "solve" and code == BAD_INPUT:
        # What left it without points says more: which classes there are, and how to keep them.
        report = records.report_path(plan, "normals", tile)
        if os.path.exists(report):
            told = [text for text in records.read_json(report).get("warnings", [])
                    if text.startswith("no points are left: ")]
            if told:
                return told[-1]
    message = last_error(log_path, "cornice-" + stages.STAGES[stage].program)
    # The tile is named beside the message.
    return message.removeprefix(records.label(plan, tile) + ": ")


def attempt(plan, stage, tile, threads):
    """Runs a job whose needs are met; returns its part of the record."""
    log_path = records.log_path(plan, stage, tile)
    code, used = run_tool(plan, stage, tile, threads, log_path)
    message = message_of(plan, stage, tile, code, log_path) if code else ""
    if stage == "info" and code == 0:
        message = problem_in_info(records.path(plan, "info", tile + ".json"))
        code = BAD_INPUT if message else 0
    return {"status": "failed" if code else "done", "exit_code": code, "message": message, **used}


def run(plan, stage, tile, threads):
    """Runs a job and leaves its record; returns the exit code that the workflow is to see."""
    before = [(name, other) for name, other, _ in stages.upstream(plan, stage, tile)]
    record = {"stage": stage, "tile": tile, "id": uuid.uuid4().hex[:16],
              "fingerprint": plan["fingerprints"][stage][tile],
              "inputs": records.inputs_digest(before, {job: records.read(plan, *job)
                                                       for job in before})}
    missing = failed_before(plan, stage, tile)
    started = time.time()
    if missing:
        record.update(status="skipped", exit_code=0, message=f"needs {missing[0]} of {missing[1]}")
    else:
        record.update(attempt(plan, stage, tile, threads))
        # Stopped from outside: nothing became of it, the next run does it again.
        if record["exit_code"] in (128 + 2, 128 + 15):
            return record["exit_code"]
    record["seconds"] = round(time.time() - started, 3)
    if record["status"] == "failed" and plan["stop_at_first_failure"]:
        print(f"{tile}: {stage}: {record['message']}", file=sys.stderr)
        return record["exit_code"]
    records.write_json(records.record_path(plan, stage, tile), record)
    return 0


def run_chain(plan, last, tile, threads):
    """Runs what has no record yet of the chain that ends with the stage `last`."""
    chain = next(chain for chain in stages.chains(plan) if chain[-1].name == last)
    for stage in chain:
        if records.read(plan, stage.name, tile) is None:
            code = run(plan, stage.name, tile, threads)
            if code != 0:
                return code
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("plan", metavar="PLAN.json")
    parser.add_argument("stage", choices=stages.STAGES, help="the last of its chain")
    parser.add_argument("tile", help="its name, or \"survey\"")
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    programs.allow_long_command_lines()
    try:
        return run_chain(records.read_json(arguments.plan), arguments.stage, arguments.tile,
                         arguments.threads)
    except OSError as error:
        # Its record, or what it needs, cannot be written: the workflow ends, and its log says why.
        print(f"{arguments.tile}: {arguments.stage}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 128 + 2


if __name__ == "__main__":
    sys.exit(main())
