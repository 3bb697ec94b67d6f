#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws how reconstruction scales over points and threads: plot.py BENCH.json PICTURE.{png,svg}"""
import json
import re
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def series(figures, pattern):
    """Pairs (number, value) of the figures whose whole name matches; k counts as thousands."""
    found = []
    for name, value in figures.items():
        match = re.fullmatch(pattern, name)
        if match:
            number, unit = match.groups()
            found.append((float(number) * (1e-3 if unit == "k" else 1.0), value))
    return sorted(found)


def draw(axis, figures, pattern, label):
    points = series(figures, pattern)
    if points:
        axis.plot(*zip(*points), marker="o", label=label)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as file:
        figures = json.load(file)["figures"]
    _, (seconds, memory, threads) = plt.subplots(1, 3, figsize=(12, 3.6), layout="tight")
    draw(seconds, figures, r"seconds_(\d+)([mk])_d11", "cornice, 0.5 m")
    draw(seconds, figures, r"poissonrecon_seconds_(\d+)([mk])_d11", "PoissonRecon, 0.5 m")
    seconds.set(xlabel="million points", ylabel="seconds", yscale="log")
    draw(seconds, figures, r"pcl_seconds_(\d+)([mk])_d11", "PCL, about 0.5 m")
    draw(memory, figures, r"gib_(\d+)([mk])_d11", "cornice, 0.5 m")
    draw(memory, figures, r"poissonrecon_gib_(\d+)([mk])_d11", "PoissonRecon, 0.5 m")
    memory.set(xlabel="million points", ylabel="GiB at the peak")
    draw(threads, figures, r"seconds_\d+[mk]_t(\d+)()", "cornice, 0.5 m")
    threads.set(xlabel="threads", ylabel="seconds", ylim=(0, None))
    for axis in (seconds, memory, threads):
        axis.grid(True, alpha=0.3)
        if axis.lines:
            axis.legend()
    plt.savefig(sys.argv[2], dpi=120)


if __name__ == "__main__":
    main()
