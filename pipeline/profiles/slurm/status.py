#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells Snakemake 7 how a Slurm job stands: running, success or failed.

Without it a job that Slurm kills (memory, time, a lost node) would be waited for without end.
"""

import re
import subprocess
import sys

RUNNING = ("PENDING", "CONFIGURING", "RUNNING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING")


def state_of(job):
    """Slurm's word for the job's state, or None where Slurm does not answer for now."""
    shown = subprocess.run(["scontrol", "show", "job", job], capture_output=True, text=True,
                           check=False)
    found = re.search(r"JobState=(\w+)", shown.stdout)
    if found:
        return found.group(1)
    # The controller forgets a job some minutes after its end; the accounting, where there is one,
    # does not.
    listed = subprocess.run(["sacct", "-X", "-n", "-P", "-o", "State", "-j", job],
                            capture_output=True, text=True, check=False)
    if listed.returncode == 0 and listed.stdout.strip():
        return listed.stdout.split()[0].rstrip("+")
    if "Invalid job id" in shown.stderr:
        return "UNKNOWN"
    return None


def main():
    state = state_of(sys.argv[1].split(";")[0])
    if state is None or state in RUNNING:
        print("running")
    else:
        print("success" if state == "COMPLETED" else "failed")


if __name__ == "__main__":
    main()
