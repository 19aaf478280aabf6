"""What an export's folder contains: the core, a program that tests it, and a README."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.export.core import Core, filled
from warmlink.fmus.component.instance import Instance

SAMPLES = 120
"""Samples of the test vectors."""

TOLERANCES = {"double": 1e-9, "single": 0.05e-6}
"""Largest difference from the test vectors: a share of each output, or m of the correction."""


def export_files(core: Core) -> dict[str, str]:
    """Text of each file of an export by name."""
    return {
        f"{core.name}.h": core.header(),
        f"{core.name}.c": core.source(),
        f"{core.name}_test.c": test_program(core),
        "README.md": readme(core),
    }


def vectors(core: Core) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Inputs and outputs of the law from a cold start, by its Python form.

    Returns
    -------
    inputs, outputs : shapes (SAMPLES + 1, u.size) and (SAMPLES + 1, y.size); the first row is the start
    """
    instance = Instance(core.component)
    given, taken = list(_inputs(core)), []
    for sample, row in enumerate(given):
        instance.set(dict(zip(core.component.u.names, row, strict=True)))
        if sample == 0:
            instance.initialize()
        else:
            instance.step((sample - 1) * core.period, core.period)
        taken.append(np.array(instance.outputs()))
    return np.array(given), np.array(taken)


def test_program(core: Core) -> str:
    """A C program that runs the core through the test vectors; it ends with 0 where they are met."""
    law, upper = core.name, core.name.upper()
    given, taken = vectors(core)
    recalls = ", 0, 0" if "recalled_for" in core.component.p.index else ""
    if core.precision == "double":
        compared, scale = f"{upper}_OUTPUTS", "fmax(1e-6, fabs(outputs[k][i]))"
    else:
        compared, scale = f"{upper}_CORRECTION + 1", "1"
    return filled(
        "test.c",
        {
            "law": law,
            "upper": upper,
            "given": _table(given),
            "taken": _table(taken),
            "count": len(given),
            "recalls": recalls,
            "compared": compared,
            "scale": scale,
            "tolerance": repr(TOLERANCES[core.precision]),
        },
    )


def readme(core: Core) -> str:
    """How to use the export, and what it needs."""
    size = 4 if core.precision == "single" else 8
    numbers = core.component.x.size + core.component.y.size
    more = (
        "\nAfter a restart, give `init` the outputs `retained` that were stored before, and the time in s\n"
        "that passed since; a null pointer where nothing was stored.\n"
        if "recalled_for" in core.component.p.index
        else ""
    )
    return filled(
        "readme.txt",
        {
            "law": core.name,
            "upper": core.name.upper(),
            "description": core.component.description,
            "precision": core.precision,
            "period": f"{core.period:g}",
            "memory": numbers * size + 8,
            "operations": core.operations(),
            "samples": SAMPLES,
            "more": more,
        },
    )


def _inputs(core: Core) -> Iterator[list[float]]:
    """A motor that starts and stops in a room that warms up, one reading missing for a while."""
    component = core.component
    _, start = component.start_values()
    for sample in range(SAMPLES + 1):
        row = dict(zip(component.u.names, start.tolist(), strict=True))
        warm = 6.0 * (1.0 - math.exp(-sample / 60.0))
        for place, name in enumerate(name for name in row if name.endswith("_temperature")):
            row[name] = 295.15 + warm / (1 + place) + 0.05 * math.sin(1.7 * sample + place)
        row["ambient_temperature"] = 295.15 + sample * core.period / 3600.0
        row["speed"], row["torque"] = (3.0, 2.5) if sample % 60 < 40 else (0.0, 0.0)
        if 50 <= sample < 70:
            row["tip_temperature"] = math.nan
        yield list(row.values())


def _table(rows: NDArray[np.float64]) -> str:
    text = "".join("    {" + ", ".join(repr(float(each)) for each in row) + "},\n" for row in rows)
    return re.sub(r"\bnan\b", "NAN", text)
