#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for every cornice program: writes the outputs asked for, and counts its runs.

A tile is a text file. A line "fail STAGE" in it makes that stage fail on it; "sleep STAGE" makes it
wait for its end; "kill STAGE" makes it die; "warn STAGE" makes it warn; "classes STAGE" makes it warn
that its class rules keep nothing.
"""

import json
import os
import signal
import sys
import time


def values_of(words, flag):
    found = []
    if flag in words:
        for word in words[words.index(flag) + 1:]:
            if word.startswith("-"):
                break
            found.append(word)
    return found


def index(tiles, target, step_m):
    entries = []
    for number, tile in enumerate(sorted(tiles)):
        name = os.path.basename(tile).split(".")[0]
        with open(tile, encoding="utf-8") as file:
            problem = "is unusable" if "unusable" in file.read() else ""
        entries.append({"name": name, "path": tile, "bytes": 10, "points": 1000, "problem": problem,
                        "box": [100.0 * number, 0.0, 100.0 * number + 100.0, 100.0]})
    names = [entry["name"] for entry in entries]
    for number, entry in enumerate(entries):
        entry["neighbours"] = [names[other] for other in (number - 1, number + 1)
                               if 0 <= other < len(names) and not entries[other]["problem"]]
    with open(target, "w", encoding="utf-8") as file:
        json.dump({"crs": "EPSG:2154", "step_m": step_m, "halo_m": 20, "tiles": entries,
                   "warnings": []}, file)


def act_as_told(stage, source):
    """The tile's wish for this stage, found through the chain of files that name their source."""
    with open(source, encoding="utf-8") as file:
        text = file.read()
    if f"fail {stage}" in text:
        print(f"cornice-{stage}: error: {source}: is bad as told", file=sys.stderr)
        sys.exit(3)
    if f"kill {stage}" in text:
        os.kill(os.getpid(), signal.SIGKILL)
    if f"sleep {stage}" in text:
        time.sleep(600)
    return text


def main():
    words = sys.argv[1:]
    stage = os.path.basename(sys.argv[0]).removeprefix("cornice-")
    if "--version" in words:
        print("cornice-index 9.9.9")
        return
    target = (values_of(words, "-o") or [""])[0]
    inputs = []
    for word in words:
        if word.startswith("-"):
            break
        inputs.append(word)
    if stage == "index":
        index([word for word in words if word.endswith(".laz")], target,
              float(values_of(words, "--step-m")[0]))
        return
    if stage == "poisson":
        stage, inputs = inputs[0], inputs[1:]
    if stage == "hlod":
        inputs = inputs[1:]
    with open(os.environ["RUNS"], "a", encoding="utf-8") as runs:
        runs.write(f"{stage} {os.path.basename(inputs[0]).split('.')[0]}\n")
    text = "".join(act_as_told(stage, source) for source in inputs[:1])
    text += "".join(f"from {name}\n" for name in inputs[1:] + values_of(words, "--neighbours"))
    if stage == "info":
        print(json.dumps({"files": [{"points": 1000, "complete": True, "defects": []}]}))
    outputs = [target] if target else []
    if stage == "solve":
        outputs.append(target.replace(".field", ".band"))
    if stage == "stitch":
        os.makedirs(target, exist_ok=True)
        outputs = [os.path.join(target, os.path.basename(name)) for name in inputs]
    if stage in ("dem", "compare"):
        os.makedirs(target, exist_ok=True)
        outputs = [os.path.join(target, "result.ply")]
    for output in outputs:
        with open(output, "w", encoding="utf-8") as file:
            file.write(text)
    report = values_of(words, "--report")
    if report:
        with open(report[0], "w", encoding="utf-8") as file:
            warned = ["is odd as told"] if f"warn {stage}" in text else []
            if f"classes {stage}" in text:
                warned.append("no points are left: there are 5 of class 1")
            json.dump({"tool": stage, "seconds": 1.0, "peak_memory_bytes": 2**20, "warnings": warned,
                       "counts": {"points": 1000}, "quality": {}, "parameters": {}, "steps": [],
                       "machine": {"cpu": "c", "cores": 2, "memory_bytes": 2**30, "os": "o"}}, file)


if __name__ == "__main__":
    main()
