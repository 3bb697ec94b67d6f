# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress over all jobs of a survey, read from the records that they leave."""

import os
import sys
import time

import stages


def duration_text(seconds):
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class Watch:
    """Counts ended jobs; tells the share done and the time left."""

    def __init__(self, plan, jobs_at_once):
        self.plan = plan
        self.jobs_at_once = jobs_at_once
        self.jobs = stages.jobs(plan)
        self.begun = time.time()
        self.ended = {}
        self.before = set(job for job in self.jobs if self._record(job) is not None)
        self.is_terminal = sys.stderr.isatty()
        self.last_line = ""
        self.last_time = 0.0

    def _record(self, job):
        target = stages.outcome_path(self.plan, *job)
        return stages.read_outcome(self.plan, *job) if os.path.exists(target) else None

    def refresh(self):
        for job in self.jobs:
            if job not in self.ended:
                record = self._record(job)
                if record is not None:
                    self.ended[job] = record

    def _expected(self, job):
        stage, tile = job
        points = stages.points_of(self.plan, tile)
        if tile == stages.SURVEY:
            points = sum(entry["points"] for entry in self.plan["tiles"].values())
        return 0.5 + stages.STAGES[stage].seconds_per_million * points / 1e6

    def seconds_left(self):
        """From what the jobs of this run took against what was expected of them."""
        new = [job for job in self.ended if job not in self.before]
        left = sum(self._expected(job) for job in self.jobs if job not in self.ended)
        if not new or not left:
            return 0.0 if not left else None
        pace = (time.time() - self.begun) / max(sum(self._expected(job) for job in new), 1e-3)
        return pace * left

    def line(self):
        total = sum(self._expected(job) for job in self.jobs)
        done = sum(self._expected(job) for job in self.ended)
        parts = []
        for name, stage in stages.STAGES.items():
            of_stage = [job for job in self.jobs if job[0] == name]
            ended = sum(1 for job in of_stage if job in self.ended)
            if of_stage and 0 < ended < len(of_stage):
                parts.append(f"{name} {ended}/{len(of_stage)}")
        failed = sum(1 for record in self.ended.values() if record["status"] == "failed")
        text = f"{100.0 * done / max(total, 1e-9):.0f} % done"
        if parts:
            text += f" ({', '.join(parts)})"
        if failed:
            text += f", {failed} failed"
        left = self.seconds_left()
        return text + (f", about {duration_text(left)} left" if left else "")

    def show(self, quiet):
        """A line that renews itself on a terminal; in a log a line now and then."""
        self.refresh()
        if quiet:
            return
        text = self.line()
        now = time.time()
        if self.is_terminal:
            sys.stderr.write("\r\033[K" + text)
            sys.stderr.flush()
        elif text != self.last_line and now - self.last_time > 10.0:
            print(f"cornice-run: {text}", file=sys.stderr, flush=True)
            self.last_line, self.last_time = text, now

    def finish(self):
        self.refresh()
        if self.is_terminal:
            sys.stderr.write("\r\033[K")
