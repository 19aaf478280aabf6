"""What a reader may change on the page: fields, each named after a variable."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from warmlink.fmus.component import Component, Parameter, Scalar, limits
from warmlink.fmus.duty_cycle.component import SEGMENTS
from warmlink.fmus.duty_cycle.equations import DEMANDS
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS
from warmlink.orchestration.scenarios.own_system import DRIVER
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.scenarios.setup import THERMOMETERS
from warmlink.orchestration.system.units import IDENTITY, Conversion, conversion, parse_unit

SPAN = 3.0
"""A slider goes from a value divided by this to the value times this."""

ROOM = 20.0
"""K by which the slider of a temperature goes up and down."""

SHORTEST, LONGEST = 10.0, 86400.0
"""Shortest segment and longest run [s]."""

OWN = ("speed", "torque")
"""Demands that each joint has for itself; all others, and the durations, are those of all joints."""

FELT = {"time": 0.25, "size": 2.0, "rate": 2.0}
"""A fault that is felt, which a reader begins with: from this share of the run on, in K, in K/h."""


class Field(NamedTuple):
    """A variable: the attributes of its field and of its slider, what it is, and names of its values."""

    shown: dict[str, Any]
    about: str
    slider: Mapping[str, Any] = {}
    texts: Sequence[str] = ()


def drivers_of(scenario: Scenario) -> list[str]:
    """Instances that drive the system's joints."""
    return [name for name, kind in scenario.setup.blueprint.components.items() if kind == DRIVER]


def vectors_of(drivers: Sequence[str]) -> list[dict[str, str]]:
    """The vectors of the duty's segments, durations first: `name`, `word`, and `driver` if only of that."""
    first = {"name": f"{drivers[0]}.duration", "word": "duration", "driver": ""}
    return [first] + [
        {"name": f"{each}.segment_{word}", "word": word, "driver": each if word in OWN else ""}
        for word in DEMANDS
        for each in (drivers if word in OWN else drivers[:1])
    ]


def form(scenario: Scenario, whole: Component, laws: Sequence[str]) -> dict[str, Any]:
    """Fields of the page by their place in it, for its template; `laws` are the names of the controllers."""
    drivers, values, stop = drivers_of(scenario), scenario.values(), scenario.stop_time
    vectors = vectors_of(drivers)
    fields = {
        scalar.name: _field(scalar, values, scalar.name.rpartition(".")[0] in drivers)
        for scalar in whole.scalars()
        if isinstance(scalar.variable, Parameter)
        and scalar.name.rpartition(".")[0] not in scenario.setup.controllers
    }
    faults = {label: _fault(kind, fields, stop) for kind, label in _thermometers(scenario)}
    known = [name.split(".") for name in (*THERMAL_PARAMETERS, EXPANSION)]
    first = [f"{part}.{name}" for kind, name in known for part in scenario.setup.blueprint.called(kind)]
    others = {field.shown["name"] for of in faults.values() for field in of}
    return {
        "laws": [Field(_shown(f"law:{law}", "page", checked=""), law) for law in laws],
        "stop": Field(
            _shown("stop", "page", f"{stop:.12g}", "s", min=scenario.step_size, max=LONGEST), "stop time"
        ),
        "repeat": fields[f"{drivers[0]}.repeat"],
        "vectors": vectors,
        "segments": [
            [(vector, fields[f"{vector['name']}[{i}]"]) for vector in vectors] for i in range(1, SEGMENTS + 1)
        ],
        "parameters": [
            fields[name]
            for name in dict.fromkeys((*first, *fields))
            if name in fields and fields[name].slider and name not in others
        ],
        "faults": faults,
    }


def _shown(
    name: str, kind: str, text: str = "", unit: str = "1", to: Conversion = IDENTITY, **more: Any
) -> dict[str, Any]:
    """Attributes of a field; it must not be emptied where it begins with a text."""
    data = {"data-kind": kind, "data-unit": unit, "data-factor": to.factor, "data-offset": to.offset}
    return {"name": name, "value": text, "required": "" if text else None, **data, **more}


def _field(scalar: Scalar, values: Mapping[str, Mapping[str, Any]], duty: bool) -> Field:
    """Field of a variable of the system, of its duty cycle or not."""
    variable, (instance, _, name) = scalar.variable, scalar.name.rpartition(".")
    value = float(values.get(instance, {}).get(name, scalar.start or 0.0))
    unit = variable.display or variable.unit
    to = conversion(parse_unit(variable.unit), parse_unit(unit), False)
    about = variable.description
    if not duty:
        text = f"{to(value):.6g}"
        slider = _slider(scalar, value, to)
        texts = variable.choice.items if variable.choice else ()
        return Field(_shown(scalar.name, "parameter", text, unit, to), about, slider, texts)
    lasts = name.startswith("duration")
    bounds = {"min": SHORTEST if lasts else None if variable.display else scalar.lower}
    checked = {"checked": ""} if variable.type == "Boolean" and value else {}
    text = f"{to(value):.12g}" if value or not lasts else ""
    shown = _shown(scalar.name, "duty", text, unit, to, **bounds, **checked)
    return Field(shown, about, texts=variable.choice.items if variable.choice else ())


def _slider(scalar: Scalar, value: float, to: Conversion) -> dict[str, Any]:
    """Attributes of a slider in the unit that is shown; with `data-powers` it is at a logarithm."""
    variable = scalar.variable
    low = -math.inf if scalar.lower is None else scalar.lower
    high = math.inf if variable.maximum is None else variable.maximum
    powers = variable.display != "degC" and value > 0 and variable.type == "Real"
    if variable.display == "degC":
        low, high = max(value - ROOM, low), min(value + ROOM, high)
    elif powers:
        low, high = value / SPAN, min(value * SPAN, high)
    else:
        high = high if high < math.inf else max(limits.ordinary_size(variable), SPAN * abs(value))
        low = max(low, -high)
    left, right = (math.log(to(end)) if powers else to(end) for end in (low, high))
    return {"min": left, "max": right, "step": (right - left) / 1000, "data-powers": "" if powers else None}


def _thermometers(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """The thermometers that controllers read: the variable that holds their fault, and what they measure."""
    blueprint = scenario.setup.blueprint
    for source, target in blueprint.wires:
        instance, _, variable = source.rpartition(".")
        reader, _, sensed = target.rpartition(".")
        if reader in scenario.setup.controllers and blueprint.components[instance] == THERMOMETERS:
            label = f"{instance.removesuffix('sensors')}{sensed.removesuffix('_temperature')}"
            yield f"{instance}.fault_kind{variable.removeprefix('reading')}", label


def _fault(kind: str, fields: Mapping[str, Field], stop: float) -> list[Field]:
    """Fields of a thermometer's fault; where the scenario has none, they begin with one that is felt."""
    found = [fields[kind]]
    for word, felt in FELT.items():
        field = fields[kind.replace("fault_kind", f"fault_{word}")]
        start, text = field.shown["value"], f"{felt * stop if word == 'time' else felt:.0f}"
        felt_anew = {"value": text, "data-start": start} if found[0].shown["value"] == "0" else {}
        found.append(field._replace(shown=field.shown | felt_anew))
    return found
