# SPDX-License-Identifier: GPL-3.0-or-later
"""How cornice's programs are run and measured."""

import os
import resource
import subprocess


def allow_long_command_lines():
    """Lets command lines be 6 MiB long instead of 2, in what this process starts: some name every
    tile of a survey. Linux gives them a quarter of the stack, up to 6 MiB."""
    room = 24 * 2**20
    soft, hard = resource.getrlimit(resource.RLIMIT_STACK)
    if soft != resource.RLIM_INFINITY and soft < room:
        resource.setrlimit(resource.RLIMIT_STACK, (
            room if hard == resource.RLIM_INFINITY else min(room, hard), hard))


def run_measured(words, **streams):
    """Runs a program to its end; (exit code, 128 + n: ended by signal n; what it used)."""
    process = subprocess.Popen(words, **streams)
    try:
        _, status, used = os.wait4(process.pid, 0)
    except BaseException:
        process.kill()
        process.wait()
        raise
    process.returncode = code = os.waitstatus_to_exitcode(status)
    return (128 - code if code < 0 else code), {
        "cpu_seconds": round(used.ru_utime + used.ru_stime, 3),
        "peak_memory_bytes": used.ru_maxrss * 1024}
