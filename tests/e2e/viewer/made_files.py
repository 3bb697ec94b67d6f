# SPDX-License-Identifier: GPL-3.0-or-later
"""Small files for the viewer to look at."""

import math
import struct
import zlib


def write_hills(path, origin="2600000 1200000 1500", crs="EPSG:2056"):
    """A PLY mesh of 200 m of hills."""
    side = 101
    vertices = b"".join(
        struct.pack("<3f", 2.0 * column, 2.0 * row,
                    20.0 * math.sin(0.05 * column) * math.cos(0.07 * row)
                    + 2.0 * math.sin(0.9 * column))
        for row in range(side) for column in range(side))
    faces = b"".join(
        struct.pack("<B3iB3i", 3, at, at + 1, at + side + 1, 3, at, at + side + 1, at + side)
        for row in range(side - 1) for at in range(row * side, row * side + side - 1))
    head = (f"ply\nformat binary_little_endian 1.0\ncomment cornice origin {origin}\n"
            f"comment cornice crs {crs}\n"
            f"element vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {2 * (side - 1) ** 2}\nproperty list uchar int vertex_indices\n"
            "end_header\n")
    with open(path, "wb") as file:
        file.write(head.encode() + vertices + faces)


def write_photograph(stem, colour, west):
    """A PNG of 100 m with a world file, of one colour."""
    def chunk(kind, data):
        whole = kind + data
        return struct.pack(">I", len(data)) + whole + struct.pack(">I", zlib.crc32(whole))
    rows = (b"\0" + bytes(colour) * 100) * 100
    with open(stem + ".png", "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n"
                   + chunk(b"IHDR", struct.pack(">IIBBBBB", 100, 100, 8, 2, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    with open(stem + ".pgw", "w", encoding="utf-8") as file:
        file.write(f"2\n0\n0\n-2\n{west + 1}\n1200199\n")


def write_differences(path):
    """An ASCII grid over the hills, -1 to 1 m from west to east."""
    row = " ".join(f"{0.1 * (column - 10):.2f}" for column in range(21))
    with open(path, "w", encoding="utf-8") as file:
        file.write("ncols 21\nnrows 21\nxllcorner 2600000\nyllcorner 1200000\ncellsize 10\n"
                   "NODATA_value -9999\n" + (row + "\n") * 21)


def pixels_of_png(path):
    """Its rows, three bytes for each pixel."""
    width, height, step, data = read_png(path)
    rows, above = [], bytes(step * width)
    for y in range(height):
        at = y * (step * width + 1)
        kind, row = data[at], bytearray(data[at + 1:at + 1 + step * width])
        for i in range(step * width):
            left = row[i - step] if i >= step else 0
            corner = above[i - step] if i >= step else 0
            # By their closeness to the plane through all three, the left one first.
            nearest = min((left, above[i], corner), key=lambda v: abs(left + above[i] - corner - v))
            row[i] = (row[i] + (0, left, above[i], (left + above[i]) // 2, nearest)[kind]) & 255
        above = bytes(row)
        rows.append(b"".join(above[at:at + 3] for at in range(0, len(above), step)))
    return rows


def read_png(path):
    """(width, height, bytes of a pixel, bytes without the filters' undoing) of a PNG."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[-8:-4] != b"IEND":
        raise ValueError(f"{path} is no whole PNG")
    width, height, depth, kind = struct.unpack_from(">IIBB", data, 16)
    packed, at = b"", 8
    while at < len(data):
        length, = struct.unpack_from(">I", data, at)
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += length + 12
    return width, height, depth // 8 * {2: 3, 6: 4}[kind], zlib.decompress(packed)
