"""What a reader may change on the page: fields, each named after a variable."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from warmlink.fmus.component import Component, Parameter, Scalar, limits
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.orchestration.machine.machine import DRIVER, THERMOMETERS
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.units import Conversion, conversion, parse_unit

SPAN = 3.0
"""A slider goes from a value divided by this to the value times this."""

ROOM = 20.0
"""K by which the slider of a temperature goes up and down."""

SHORTEST, LONGEST = 0.001, 86400.0
"""Shortest segment and longest run [s]."""

OWN = ("speed", "torque")
"""Demands that each joint has for itself; all others, and the durations, are those of all joints."""

FELT = {"time": 0.25, "size": 2.0, "rate": 2.0}
"""A fault that is felt, which a reader begins with: from this share of the run on, in K, in K/h."""


class Field(NamedTuple):
    """A variable: the attributes of its field and of its slider, what it is, and names of its values."""

    shown: dict[str, Any]
    about: str
    slider: Mapping[str, Any]
    texts: Sequence[str]


def drivers_of(scenario: Scenario) -> list[str]:
    """Instances that drive the system's joints."""
    return [name for name, kind in scenario.machine.parts.items() if kind == DRIVER]


def words_of(drivers: Sequence[str]) -> dict[str, list[str]]:
    """Vectors that hold the duty's segments by what they hold, one for each joint that has its own.

    None of them where the duty is recorded.
    """
    if not drivers:
        return {}
    demands = {w: [f"{each}.segment_{w}" for each in drivers[: None if w in OWN else 1]] for w in DEMANDS}
    return {"duration": [f"{drivers[0]}.duration"], **demands}


def form(scenario: Scenario, whole: Component) -> dict[str, Any]:
    """Fields of the page by name or by their place in it, for its template."""
    drivers, values = drivers_of(scenario), scenario.values()
    fields, kept = {}, bool(scenario.mismatches)  # only a file says what a mismatch would change once more
    for scalar in whole.scalars():
        instance, _, name = scalar.name.rpartition(".")
        if isinstance(scalar.variable, Parameter) and instance not in scenario.machine.controllers:
            value = float(values.get(instance, {}).get(name, scalar.start or 0.0))
            fields[scalar.name] = _field(scalar, value, instance in drivers, kept)
    durations = [fields[f"{first}.duration[{i}]"] for first in drivers[:1] for i in range(1, SEGMENTS + 1)]
    faults = {label: _fault(kind, fields, scenario.stop_time) for kind, label in _thermometers(scenario)}
    known = [name.split(".") for name in (*THERMAL_PARAMETERS, EXPANSION)]
    first = [f"{part}.{name}" for kind, name in known for part in scenario.machine.called(kind)]
    others = {field.shown["name"] for of in faults.values() for field in of}
    return {
        "fields": fields,
        "columns": list(_columns(drivers, fields)),
        "used": max(
            (i for i, each in enumerate(durations, start=1) if each.shown["value"] != "0"), default=0
        ),
        "parameters": [
            fields[name]
            for name in dict.fromkeys((*first, *fields))
            if name in fields and fields[name].slider and name not in others
        ],
        "faults": faults,
        "stop": _stop(scenario),
    }


def _columns(drivers: Sequence[str], fields: Mapping[str, Field]) -> Iterator[tuple[str, str, str, str]]:
    """Columns of the duty's table: what each holds, its vector, its joint unless shared, its heading."""
    for word, names in words_of(drivers).items():
        for name in names:
            unit, told = fields[f"{name}[1]"].shown["data-unit"], word.replace("_", " ")
            joint = f"{name.partition('.')[0]}." if len(names) > 1 else ""
            yield told, name, joint, f"{told} [{unit}]" if unit else told


def longest(scenario: Scenario) -> float:
    """Longest run in s that the page takes."""
    return max(LONGEST, scenario.stop_time)


def _stop(scenario: Scenario) -> Field:
    shown: dict[str, Any] = {"name": "stop", "value": f"{scenario.stop_time:.12g}", "min": scenario.step_size}
    shown["max"] = longest(scenario)
    shown |= {"data-kind": "page", "data-unit": "s", "data-factor": 1, "data-offset": 0}
    return Field(shown, "stop time", {}, ())


def _field(scalar: Scalar, value: float, duty: bool, mismatched: bool) -> Field:
    """Field of a variable; those of a vector of the duty cycle share a name."""
    variable, texts = scalar.variable, scalar.variable.choice.items if scalar.variable.choice else ()
    unit = variable.display or variable.unit
    to = conversion(parse_unit(variable.unit), parse_unit(unit))
    shown = {
        "name": variable.name if duty else scalar.name,
        "value": f"{to(value):.{12 if duty else 6}g}",
        "data-kind": "duty" if duty else "parameter",
        "data-unit": "" if unit == "1" else unit,
        "data-factor": to.factor,
        "data-offset": to.offset,
        "data-file": "" if duty or mismatched else None,
    }
    if not duty:
        return Field(shown, variable.description, _slider(scalar, value, to), texts)
    lasts = variable.name.endswith(".duration")
    shown["min"] = SHORTEST if lasts else None if variable.display else scalar.lower
    return Field(shown, variable.description, {}, ("no", "yes") if variable.type == "Boolean" else texts)


def _slider(scalar: Scalar, value: float, to: Conversion) -> dict[str, Any]:
    """Attributes of a slider in the unit that is shown; with `data-powers` it is at a logarithm."""
    variable = scalar.variable
    low = -math.inf if scalar.lower is None else scalar.lower
    high = math.inf if variable.maximum is None else variable.maximum
    powers = variable.display != "degC" and value > 0 and variable.type == "Real"
    if variable.display == "degC":
        low, high = max(value - ROOM, low), min(value + ROOM, high)
    elif powers:
        low, high = max(value / SPAN, low), min(value * SPAN, high)
    else:
        high = high if high < math.inf else max(limits.ordinary_size(variable), SPAN * abs(value))
        low = max(low, -high)
    left, right = (math.log(to(end)) if powers else to(end) for end in (low, high))
    step = (right - left) / 1000 if variable.type == "Real" else 1
    return {"min": left, "max": right, "step": step, "data-powers": "" if powers else None}


def _thermometers(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """The thermometers that controllers read: the variable that holds their fault, and what they measure."""
    machine = scenario.machine
    for source, target in machine.wires:
        instance, _, variable = source.rpartition(".")
        reader, _, sensed = target.rpartition(".")
        if reader in machine.controllers and machine.parts[instance] == THERMOMETERS:
            label = f"{instance.removesuffix('sensors')}{sensed.removesuffix('_temperature')}"
            yield f"{instance}.fault_kind{variable.removeprefix('reading')}", label


def _fault(kind: str, fields: Mapping[str, Field], stop: float) -> list[Field]:
    """Fields of a thermometer's fault; where it has none, one that is felt, which is disabled."""
    found = [fields[kind]]
    for word, felt in FELT.items():
        field = fields[kind.replace("fault_kind", f"fault_{word}")]
        unused = {"value": f"{felt * stop if word == 'time' else felt:.0f}", "disabled": ""}
        found.append(field._replace(shown=field.shown | (unused if found[0].shown["value"] == "0" else {})))
    return found
