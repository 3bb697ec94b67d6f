# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress over all jobs of a survey, read from the records that they leave."""

import os
import sys
import time

import records
import stages


def duration_text(seconds):
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class Folder:
    """The records of one stage; reads each of them once, and lists them only when they change."""

    # A record that comes in the same tick of the file system's clock does not show in the time.
    TICK_NS = 2_000_000_000

    def __init__(self, plan, stage):
        self.plan, self.stage = plan, stage
        self.folder = records.folder(plan, stage)
        self.listed_at = None
        self.seen = set()

    def new_records(self):
        """(tile, record) of those that were not there before."""
        try:
            changed = os.stat(self.folder).st_mtime_ns
        except FileNotFoundError:
            return
        if self.listed_at is not None and changed < self.listed_at:
            return
        # Times of the file system alone: its clock may differ from this machine's.
        self.listed_at = changed + 1 if time.time_ns() - changed > self.TICK_NS else changed
        for name in os.listdir(self.folder):
            tile = name.removesuffix(".json")
            if tile != name and tile not in self.seen:
                record = records.read(self.plan, self.stage, tile)
                if record is not None:
                    self.seen.add(tile)
                    yield tile, record


class Watch:
    """Counts ended jobs; tells the share done and the time left."""

    def __init__(self, plan, left, at_once=1):
        """left: the jobs that are to be done now (todo.find); at_once: how many of them."""
        self.expected = stages.expected_times(plan)
        self.total = sum(self.expected.values())
        self.left = sum(self.expected[job] for job in left)
        self.waiting = set(left)
        self.todo = len(left)
        self.jobs = {stage.name: len(stages.tiles_of(plan, stage)) for stage in stages.active(plan)}
        self.order = {stage: number for number, stage in enumerate(self.jobs)}
        self.ended = dict(self.jobs)
        for stage, _ in left:
            self.ended[stage] -= 1
        self.failed = 0
        self.folders = [Folder(plan, stage) for stage in self.jobs]
        self.at_once = at_once
        self.first = None  # time and work left when the first job ended: planning counts for nothing
        self.last_end = 0.0  # when the last job was seen to have ended
        self.is_terminal = sys.stderr.isatty()
        self.last_line = ""
        self.last_time = 0.0

    def refresh(self):
        for folder in self.folders:
            for tile, record in folder.new_records():
                job = (folder.stage, tile)
                self.failed += record["status"] == "failed" and job in self.expected
                if job in self.waiting:
                    self.waiting.remove(job)
                    self.left -= self.expected[job]
                    self.ended[folder.stage] += 1
                    self.last_end = time.time()
        if self.first is None and len(self.waiting) < self.todo:
            self.first = (time.time(), self.left)

    def under_way(self):
        """The most work that the jobs now running can have done: that of the longest that may run."""
        soonest = min(self.waiting, key=lambda job: self.order[job[0]])
        per = stages.STAGES[soonest[0]].per
        return self.at_once * max(self.expected[job] for job in self.waiting
                                  if stages.STAGES[job[0]].per == per)

    def seconds_left(self):
        """From what the jobs of this run took against what was expected of them; None: no telling
        yet. Jobs that run are taken to go on at that pace, until they have taken longer than was
        expected of them: then all is taken to be slower."""
        if not self.waiting:
            return 0.0
        if self.first is None or self.first[1] <= self.left:
            return None
        began, work = self.first
        done = work - self.left
        now = time.time()
        pace = done / max(self.last_end - began, 1e-3)
        running = min(pace * (now - self.last_end), 0.95 * self.under_way(), 0.95 * self.left)
        return (self.left - running) * (now - began) / (done + running)

    def line(self):
        share = 100.0 * (1.0 - self.left / self.total) if self.total else 100.0
        text = f"{share:.0f} % done"
        parts = [f"{stage} {self.ended[stage]}/{count}" for stage, count in self.jobs.items()
                 if 0 < self.ended[stage] < count]
        if parts:
            text += f" ({', '.join(parts)})"
        if self.failed:
            text += f", {self.failed} failed"
        left = self.seconds_left()
        return text + (f", about {duration_text(left)} left" if left else "")

    def show(self, quiet):
        """A line that renews itself on a terminal; in a log a line now and then."""
        if quiet:
            return
        self.refresh()
        text = self.line()
        now = time.time()
        if self.is_terminal:
            sys.stderr.write("\r\033[K" + text)
            sys.stderr.flush()
        elif text != self.last_line and now - self.last_time > 10.0:
            print(f"cornice-run: {text}", file=sys.stderr, flush=True)
            self.last_line, self.last_time = text, now

    def finish(self):
        if self.is_terminal:
            sys.stderr.write("\r\033[K")
