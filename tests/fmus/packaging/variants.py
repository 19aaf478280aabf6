"""Components that are not warmlink's own, for FMUs that must not be mistaken for one another."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

from warmlink.fmus.catalogue import Entry

_OTHER_MOTOR = """
from dataclasses import replace

from warmlink.fmus.motor_heat_source import equations
from warmlink.fmus.motor_heat_source.component import COMPONENT as ORIGINAL


def outputs(x, u, p, time):
    values = dict(equations.outputs(x, u, p, time))
    return values | {"heat_flow": 2 * values["heat_flow"]}


COMPONENT = replace(ORIGINAL, observe=outputs)
"""

_FAILING_MOTOR = """
from dataclasses import replace

from warmlink.fmus.motor_heat_source import equations
from warmlink.fmus.motor_heat_source.component import COMPONENT as ORIGINAL


def rates(x, u, p, time):
    if time > 2.5:
        raise ArithmeticError("the magic smoke got out")
    return equations.rates(x, u, p, time)


COMPONENT = replace(ORIGINAL, rates=rates)
"""


def _declared(folder: Path, name: str, source: str) -> Entry:
    package = folder / name
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("", "utf-8")
    (package / "component.py").write_text(source, "utf-8")
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        module = importlib.import_module(f"{name}.component")
    finally:
        sys.path.remove(str(folder))
    return Entry(module.COMPONENT, f"{name}.component")


def other_motor(folder: Path) -> Entry:
    """MotorHeatSource by name and interface, with twice the heat flow."""
    return _declared(folder, "other_motor", _OTHER_MOTOR)


def failing_motor(folder: Path) -> Entry:
    """MotorHeatSource that raises in a step after 2.5 s."""
    return _declared(folder, "failing_motor", _FAILING_MOTOR)
