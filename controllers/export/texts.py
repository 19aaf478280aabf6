"""Files made of templates, and tables of variables in them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from string import Template

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.program.statements import Slot


def filled(core: Core, template: str, **more: object) -> str:
    """Text of a file in `templates` with values in place of their names, as `${law}`."""
    path = Path(__file__).parent / "templates" / template
    return Template(path.read_text("utf-8")).substitute(
        law=core.name,
        upper=core.name.upper(),
        description=core.description,
        period=f"{core.period:g}",
        **more,
    )


def listed(slots: Iterable[Slot], values: bool = False) -> str:
    """A table of variables."""
    rows = ["| name | unit | what it is |", "|---|---|---|"]
    if values:
        rows = ["| name | value | unit | what it is |", "|---|---|---|---|"]
    for slot in slots:
        name = f"`{slot.name}[{slot.size}]`" if slot.shape else f"`{slot.name}`"
        told = ""
        if values:
            first = ", ".join(f"{float(each):g}" for each in slot.values[:6])
            told = f" {first}{', ...' if slot.size > 6 else ''} |"
        rows.append(f"| {name} |{told} {slot.unit} | {slot.about} |")
    return "\n".join(rows)
