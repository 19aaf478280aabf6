"""The picture of a component that tools show on its block: initials in a box, ports at its sides."""

from __future__ import annotations

import math
import struct
import zlib
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.packaging.component import Component

SIZE = 128
"""Width and height in pixels."""

Plane = NDArray[np.float64]

_PLANT = ((0xB4, 0x4A, 0x2A), (0xFB, 0xEC, 0xE4))
_SAMPLED = ((0x1F, 0x5A, 0x8A), (0xE6, 0xF0, 0xF8))
_BOX = (16.0, 16.0, 112.0, 112.0)
_CORNER, _BORDER, _STROKE, _PORT = 14.0, 2.5, 3.2, 4.0

# Letters as polylines on a grid 4 wide and 6 high, x to the right and y up.
_LETTERS = {
    "A": "00 26 40,0.7 2 3.3 2",
    "B": "00 06 26 35 35 26,03 23 32 31 20 00",
    "C": "41 30 10 01 05 16 36 45",
    "D": "00 06 26 44 42 20 00",
    "E": "40 00 06 46,03 33",
    "F": "00 06 46,03 33",
    "G": "45 36 16 05 01 10 30 41 43 23",
    "H": "00 06,40 46,03 43",
    "I": "20 26,10 30,16 36",
    "J": "36 31 20 10 01",
    "K": "00 06,46 03 40",
    "L": "06 00 40",
    "M": "00 06 23 46 40",
    "N": "00 06 40 46",
    "O": "10 01 05 16 36 45 41 30 10",
    "P": "00 06 36 45 44 33 03",
    "Q": "10 01 05 16 36 45 41 30 10,22 40",
    "R": "00 06 36 45 44 33 03,23 40",
    "S": "45 36 16 05 04 13 33 42 41 30 10 01",
    "T": "20 26,06 46",
    "U": "06 01 10 30 41 46",
    "V": "06 20 46",
    "W": "06 10 23 30 46",
    "X": "00 46,06 40",
    "Y": "06 23 46,23 20",
    "Z": "06 46 00 40",
}


def icon(component: Component) -> bytes:
    """PNG of `SIZE` by `SIZE` pixels with a transparent ground.

    Parameters
    ----------
    component : gives the initials, the number of ports, and by its kind the colour
    """
    ink, ground = _SAMPLED if component.sampled else _PLANT
    image = np.zeros((SIZE, SIZE, 4))
    image[:, :, :3] = ground
    box = _box_distance()
    image[:, :, 3] = _covered(box)
    _paint(image, ink, _covered(np.abs(box) - _BORDER / 2))
    for side, count in ((_BOX[0], len(component.inputs)), (_BOX[2], len(component.outputs))):
        _paint(image, ink, _ports(side, min(count, 8)))
    _paint(image, ink, _initials("".join(c for c in component.name if c in _LETTERS)[:3]))
    image[:, :, 3] *= 255
    return _png(np.round(image).astype(np.uint8))


def _pixels() -> tuple[Plane, Plane]:
    centres = np.arange(SIZE) + 0.5
    x, y = np.meshgrid(centres, centres)
    return x, y


def _covered(distance: Plane) -> Plane:
    """Share of each pixel inside a shape, from the distance to its edge, negative inside."""
    return np.clip(0.5 - distance, 0.0, 1.0)


def _paint(image: Plane, colour: tuple[int, int, int], share: Plane) -> None:
    image[:, :, :3] += share[:, :, None] * (np.array(colour) - image[:, :, :3])
    image[:, :, 3] = np.maximum(image[:, :, 3], share)


def _box_distance() -> Plane:
    x, y = _pixels()
    left, top, right, bottom = _BOX
    across = np.abs(x - (left + right) / 2) - (right - left) / 2 + _CORNER
    down = np.abs(y - (top + bottom) / 2) - (bottom - top) / 2 + _CORNER
    outside = np.hypot(np.maximum(across, 0), np.maximum(down, 0))
    return outside + np.minimum(np.maximum(across, down), 0) - _CORNER


def _ports(side: float, count: int) -> Plane:
    x, y = _pixels()
    share = np.zeros((SIZE, SIZE))
    for i in range(count):
        place = _BOX[1] + (_BOX[3] - _BOX[1]) * (i + 1) / (count + 1)
        share = np.maximum(share, _covered(np.hypot(x - side, y - place) - _PORT))
    return share


def _initials(text: str) -> Plane:
    """Letters side by side in the middle of the box."""
    if not text:
        return np.zeros((SIZE, SIZE))
    unit = min(7.0, 76.0 / (5.6 * len(text) - 1.6))
    left = SIZE / 2 - unit * (5.6 * len(text) - 1.6) / 2
    distance = np.full((SIZE, SIZE), np.inf)
    for i, letter in enumerate(text):
        for stroke in _LETTERS[letter].split(","):
            points = [(left + unit * (5.6 * i + x), SIZE / 2 + unit * (3 - y)) for x, y in _points(stroke)]
            for start, end in pairwise(points):
                distance = np.minimum(distance, _segment_distance(start, end))
    return _covered(distance - _STROKE * unit / 7)


def _points(stroke: str) -> list[tuple[float, float]]:
    """Points of a stroke: `06` is a point on the grid; a lone number takes the next one with it."""
    words = stroke.split()
    if all(len(word) == 2 for word in words):
        return [(float(word[0]), float(word[1])) for word in words]
    numbers = [float(word) for word in words]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def _segment_distance(start: tuple[float, float], end: tuple[float, float]) -> Plane:
    x, y = _pixels()
    along = (end[0] - start[0], end[1] - start[1])
    share = ((x - start[0]) * along[0] + (y - start[1]) * along[1]) / math.hypot(*along) ** 2
    share = np.clip(share, 0.0, 1.0)
    return np.hypot(x - start[0] - share * along[0], y - start[1] - share * along[1])


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """PNG (ISO/IEC 15948) of 8-bit red, green, blue and alpha, shape (height, width, 4)."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows, 9)),
        (b"IEND", b""),
    )
    chunks = (
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
