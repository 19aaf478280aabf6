"""Files made of templates, and tables of variables in them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from string import Template

import numpy as np

from warmlink.controllers.export.core import Core, in_comment
from warmlink.controllers.export.program.program import RECALLED
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


def listed(slots: Iterable[Slot]) -> str:
    """A table of variables."""
    rows = ["| name | unit | what it is |", "|---|---|---|"]
    for slot in slots:
        name = f"`{slot.name}[{slot.size}]`" if slot.shape else f"`{slot.name}`"
        rows.append(f"| {name} | {slot.unit} | {slot.about} |")
    return "\n".join(rows)


def parameters(core: Core) -> str:
    """A table of the law's parameters, with their values and units."""
    rows = ["| name | value | unit | what it is |", "|---|---|---|---|"]
    component = core.component
    values = component.p.values(component.start_values()[0])
    for each in component.parameters:
        if each.name in RECALLED:
            continue
        given = np.atleast_1d(np.asarray(values[each.name], dtype=float))
        first = ", ".join(f"{value:g}" for value in given[:_MOST])
        more = f", ... ({given.size})" if given.size > _MOST else ""
        rows.append(f"| `{each.name}` | {first}{more} | {each.unit} | {in_comment(each.description)} |")
    return "\n".join(rows)


_MOST = 6
"""Elements of a parameter that are shown."""
