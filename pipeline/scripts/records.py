# SPDX-License-Identifier: GPL-3.0-or-later
"""The records that jobs leave in the output folder: state/STAGE/TILE.json.

A record has "status" (done, failed, skipped), "exit_code", "message", "seconds", "cpu_seconds",
"peak_memory_bytes"; "fingerprint" of what the job was told; its own "id", and "inputs", which sums
up the ids of the records that it was made from.
"""

import contextlib
import hashlib
import json
import os

SURVEY = "survey"


def path(plan, *parts):
    return os.path.join(plan["output"], *parts)


def label(plan, tile):
    """How messages name a job's subject: a tile, the survey or a region of it."""
    if tile in plan["tiles"]:
        return plan["tiles"][tile]["path"]
    return "the survey" if tile == SURVEY else f"region {tile}"


def folder(plan, stage):
    return path(plan, "state", stage)


def record_path(plan, stage, tile):
    return os.path.join(folder(plan, stage), tile + ".json")


def log_path(plan, stage, tile):
    return path(plan, "logs", stage, tile + ".log")


def report_path(plan, stage, tile):
    return path(plan, "reports", stage, tile + ".json")


def read_json(target):
    with open(target, encoding="utf-8") as file:
        return json.load(file)


def write_text(target, text):
    """Appears whole or not at all."""
    os.makedirs(os.path.dirname(target), exist_ok=True)
    partial = f"{target}.{os.getpid()}.partial"
    try:
        with open(partial, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(partial, target)
    except BaseException as error:
        with contextlib.suppress(FileNotFoundError):
            os.remove(partial)
        if isinstance(error, OSError):
            error.filename = target
        raise


def write_json(target, value):
    # In one piece, for json.dump is ten times slower.
    write_text(target, json.dumps(value, separators=(",", ":")) + "\n")


def read(plan, stage, tile):
    """What became of a job, or None where it has not ended."""
    try:
        return read_json(record_path(plan, stage, tile))
    except FileNotFoundError:
        return None


def has_succeeded(plan, stage, tile):
    record = read(plan, stage, tile)
    return record is not None and record["status"] == "done"


def succeeded(plan, stage, tiles):
    """Those of `tiles` whose job of `stage` has succeeded, in their order."""
    return [tile for tile in tiles if has_succeeded(plan, stage, tile)]


def inputs_digest(jobs, found):
    """Sums up the records that a job is made from: jobs (stage, tile), found {job: record}."""
    ids = [(found.get(job) or {}).get("id", "") for job in jobs]
    return hashlib.sha256("\n".join(ids).encode()).hexdigest()[:16]
