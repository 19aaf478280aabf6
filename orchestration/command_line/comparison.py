"""The table that `warmlink compare` prints, and what its marks mean."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.text import Text

    from warmlink.orchestration.studies.compare import Comparison, Row

BEST, BEYOND, HARM = "*", "!", "!!"
LEGEND = (
    f"{BEST} best in its row, or equal to it within the error budget   {BEYOND} beyond tolerance   "
    f"{HARM} worse than no compensation"
)


def _parts(comparison: Comparison) -> dict[str, list[str]]:
    """Mismatches of each part of the table, by its heading: the nominal one, and the worst of the others."""
    from warmlink.orchestration.scenarios.mismatch import NOMINAL

    others = [name for name in comparison.mismatches if name != NOMINAL]
    parts = {NOMINAL: [NOMINAL]} if NOMINAL in comparison.mismatches else {}
    if others:
        parts[others[0] if len(others) == 1 else f"worst of {len(others)} mismatches"] = others
    return parts


def legend(comparison: Comparison) -> str:
    """What the marks of the table mean, and the numbers by which a figure says which mismatch it is of."""
    lines = [LEGEND]
    for mismatches in _parts(comparison).values():
        if len(mismatches) > 1:
            which = "  ".join(f"({i}) {name}" for i, name in enumerate(mismatches, start=1))
            lines.append(
                f"{which}: mismatch of the figure; a share is of no compensation under the same mismatch"
            )
    return "\n".join(lines)


def table(comparison: Comparison) -> list[tuple[str | Text, ...]]:
    """Rows of the table: a duty cycle each, with the cells of all controllers."""
    from rich.text import Text

    parts = _parts(comparison)
    first = next(iter(parts.values()))[0]
    rows: list[tuple[str | Text, ...]] = []
    for heading, mismatches in parts.items():
        rows.append((Text(heading, "bold"),))
        which = {name: f" ({i})" for i, name in enumerate(mismatches, start=1)}
        which = which if len(mismatches) > 1 else dict.fromkeys(mismatches, "")
        for duty in comparison.duty_cycles:
            held = [comparison.worst(name, [duty], mismatches) for name in comparison.controllers]
            best = min((row.outcome.max_abs_um for row in held if row.outcome.stopped is None), default=0.0)
            rows.append((f"  {duty}", *(_cell(row, best, which[row.mismatch]) for row in held)))
    won = [
        sum(comparison.row(name, duty, first).minutes_won for duty in comparison.duty_cycles)
        for name in comparison.controllers
    ]
    title = ("productive minutes won compared with warming up first", "bold"), f" ({first}, all rows)"
    return [
        *rows,
        (Text.assemble(*title), *(f"{each:+.0f}{'   ' if i else ''}" for i, each in enumerate(won))),
    ]


def _cell(row: Row, best_um: float, which: str) -> str:
    """Figures of one run with their marks; `best_um` is the smallest largest error of its row.

    `which` says of which mismatch they are, where the row is of several.
    """
    from warmlink.orchestration.closed_loop.metrics import shown_percent
    from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER

    if row.outcome.stopped is not None:
        return f"stopped{which} {HARM:<3}"
    error = f"{row.outcome.max_abs_um:.1f}{which}"
    if row.controller == NO_CONTROLLER:
        return error
    removed = "" if row.removed_percent is None else shown_percent(row.removed_percent)
    mark = HARM if row.worse_than_none else BEYOND if row.beyond_tolerance else ""
    return f"{error} {removed:>5} {mark + (BEST if row.equals(best_um) else ''):<3}"
