# SPDX-License-Identifier: GPL-3.0-or-later
"""A display that nobody looks at, and what is on it."""

import operator
import os
import struct
import subprocess


class Display:
    """An X server without a screen to look at."""

    def __init__(self, folder):
        self.frame = os.path.join(folder, "Xvfb_screen0")
        reading, writing = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", "900x700x24", "-fbdir", folder,
             "-nolisten", "tcp", "-noreset"], pass_fds=[writing], stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise RuntimeError("Xvfb does not start")
        self.environment = dict(os.environ, DISPLAY=":" + number)
        self.environment.pop("WAYLAND_DISPLAY", None)

    def close(self):
        self.server.terminate()
        self.server.wait()

    def do(self, *words):
        done = subprocess.run(["xdotool", *words], env=self.environment, capture_output=True,
                              text=True, check=False, timeout=120)
        return done.stdout.strip()

    def pixels(self):
        """Of the whole screen, as XWD files have them: four bytes each, row by row."""
        with open(self.frame, "rb") as file:
            data = file.read()
        header = struct.unpack_from(">25I", data)
        width, height, line = header[4], header[5], header[12]
        start = header[0] + 12 * header[19]
        return b"".join(data[start + row * line:start + row * line + 4 * width]
                        for row in range(height))


def share_changed(before, after):
    """Of the bytes of two screens, every 13th looked at, those that differ."""
    before, after = before[::13], after[::13]
    return sum(map(operator.ne, before, after)) / len(before)


def ground_of(screen):
    """What of a screen is between the panels."""
    return b"".join(screen[4 * (900 * y + 150):4 * (900 * y + 450)] for y in range(100, 320))
