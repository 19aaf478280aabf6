"""Where the parts of a system are drawn: by data flow, as a person would."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import TypeVar

WIDTH, GAP, PITCH = 40.0, 40.0, 4.0
"""Width of a part, space between parts, and height for each connector, in the units of the drawing (mm)."""

Box = tuple[float, float, float, float]
"""x1, y1 of the lower left corner and x2, y2 of the upper right one; y grows upward."""

Part = TypeVar("Part", bound=Hashable)


def boxes(kinds: Mapping[Part, Sequence[str]], links: Iterable[tuple[Part, Part]]) -> dict[Part, Box]:
    """Give each part its place, from the kinds of its connectors.

    A part stands one column right of the last part before it, in the order given, that feeds it; what comes
    back from later parts moves nothing. Its height follows from how many connectors its longer side has; the
    links name the parts that are connected, from and to, empty for the system around them.
    """
    order = list(kinds)
    column: dict[Part, int] = {}
    feeding = set(links)
    for place, name in enumerate(order):
        before = [column[giver] for giver in order[:place] if (giver, name) in feeding]
        column[name] = max(before, default=-1) + 1
    top = Counter[int]()
    found = {}
    for name, shown in kinds.items():
        longer = max(shown.count("input"), shown.count("output"))
        x, height = column[name] * (WIDTH + GAP), int(PITCH * (longer + 1))
        y = 0.0 - top[column[name]]
        top[column[name]] += height + int(GAP / 2)
        found[name] = (x, y - height, x + WIDTH, y)
    return found


def places(kinds: Sequence[str]) -> list[tuple[float, float] | None]:
    """Give places on a part's edges, from 0 to 1: inputs left, outputs right, others nowhere."""
    side = {"input": 0.0, "output": 1.0}
    count, met = Counter(kinds), Counter[str]()
    found: list[tuple[float, float] | None] = []
    for kind in kinds:
        met[kind] += 1
        x = side.get(kind)
        found.append(None if x is None else (x, 1 - met[kind] / (count[kind] + 1)))
    return found
