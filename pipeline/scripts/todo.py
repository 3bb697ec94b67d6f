# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left to do of a survey: jobs without a record, and those whose record no longer holds."""

import collections
import hashlib
import json
import os

import records
import stages

BAD_INPUT = 3


def modified(file_path):
    """What changes with a file's content: its size and time, or None where it is gone."""
    try:
        status = os.stat(file_path)
    except OSError:
        return None
    return [status.st_size, status.st_mtime_ns]


def fingerprints(plan, version):
    """One per job: what decides its result besides the records that it is made from."""
    config = plan["config"]
    result = {}
    for stage in stages.STAGES.values():
        common = [version, stage.name, config.get(stage.program), config.get("crs"),
                  config.get("product"), plan["step_m"], plan["halo_m"]]
        if stage.reads:
            common.append([[os.path.basename(name), changed]
                           for name, changed in plan.get(stage.reads, {}).items()])
        # Whatever reads the tile itself is made from its info's record, too.
        key = "box" if stage.name != "info" else "modified"
        result[stage.name] = {}
        for tile in stages.tiles_of(plan, stage):
            own = plan["tiles"][tile][key] if stage.per == "tile" else tile
            text = json.dumps([common, own], sort_keys=True)
            result[stage.name][tile] = hashlib.sha256(text.encode()).hexdigest()[:16]
    return result


def holds(plan, job, record, before, found):
    """Whether a job's record still says what the job would say now."""
    stage, tile = job
    if record is None or record.get("fingerprint") != plan["fingerprints"][stage][tile]:
        return False
    if record.get("inputs") != records.inputs_digest(before, found):
        return False
    if record["status"] == "failed":
        # The same bad input fails again; disks, memory and networks may have recovered.
        return record["exit_code"] == BAD_INPUT
    return record["status"] == "skipped" or all(
        os.path.exists(name) for name in stages.STAGES[stage].outputs(plan, tile))


def find(plan):
    """The jobs to do, in the order of the stages, and the records of the others: (list, dict)."""
    left, found = [], {}
    waiting = set()
    for job in stages.jobs(plan):
        before = [(stage, tile) for stage, tile, _ in stages.upstream(plan, *job)]
        record = None
        if waiting.isdisjoint(before):
            record = records.read(plan, *job)
        if record is not None and holds(plan, job, record, before, found):
            found[job] = record
        else:
            left.append(job)
            waiting.add(job)
    return left, found


def forget(plan, jobs):
    """Removes the records of jobs that are to be done again."""
    for job in jobs:
        try:
            os.remove(records.record_path(plan, *job))
        except FileNotFoundError:
            pass


def counts(jobs):
    """{stage: number of its jobs}"""
    return collections.Counter(stage for stage, _ in jobs)
