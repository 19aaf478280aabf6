"""Whether what a run recorded still means something: the bands that the components declare.

The recorded values are looked at after the run, so that no step takes longer. A value outside its band is
remarked on; one that lies far outside ends the results before it, with the likely cause.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from warmlink.fmus.component import Component, Output, Parameter, Scalar
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.variables import Band
from warmlink.orchestration import catalogue
from warmlink.orchestration.machine.read import is_ours
from warmlink.orchestration.master.recording.result import RecordTable, Result
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import StartValues, System, Value
from warmlink.orchestration.system.units import conversion, parse_unit

STANDS_OUT = 2.0
"""Times by which an input or parameter is off its ordinary size where it is named as the likely cause."""


@dataclass(frozen=True)
class Declared:
    """What is known of a system: the declaration of each instance of ours, wires and start values in SI.

    `fed` has the output behind each input that a wire feeds.
    """

    components: Mapping[str, Component]
    fed: Mapping[str, str]
    values: StartValues

    @property
    def bands(self) -> dict[str, Scalar]:
        """Variables that have a band, by `instance.variable`."""
        return {
            f"{instance}.{scalar.name}": scalar
            for instance, component in self.components.items()
            for scalar in component.scalars()
            if scalar.variable.plausible is not None
        }


def tight(components: Mapping[str, Component]) -> list[str]:
    """Variables whose bands say why they are left: what a study watches, which records little."""
    known = Declared(components, {}, {}).bands.items()
    return [name for name, scalar in known if scalar.variable.plausible and scalar.variable.plausible.why]


def declared_in(system: System) -> Declared:
    """What is known of a system that was read from an SSP."""
    components, shipped = {}, catalogue.components()
    for name, held in system.components.items():
        declared = shipped.get(read_description(held.fmu).model_name)
        if declared is not None and is_ours(held.fmu, declared):
            components[name] = declared
    fed = {each.target: each.source for each in system.connections}
    return Declared(components, fed, {name: held.values for name, held in system.components.items()})


def shipped_components(kinds: Mapping[str, str]) -> dict[str, Component]:
    """Declarations of the instances that are shipped components, by the names of their components."""
    known = catalogue.components()
    return {instance: known[kind] for instance, kind in kinds.items() if kind in known}


def first_implausible(table: RecordTable, system: Declared) -> str | None:
    """Sentence on the variable that left its band first, None if none did."""
    first = _first(table, system, far=False)
    return None if first is None else _sentence(table, system, *first, "outside")


def within_bands(result: Result, system: Declared) -> Result:
    """The result with a remark if a variable left its band, and ended before any is far outside of it."""
    table = result.table
    first = _first(table, system, far=False)
    far = None if first is None else _first(table, system, far=True)
    if first is None:
        return result if result.error is None else _with_cause(result, system)
    if far is None:
        told = _sentence(table, system, *first, "outside")
        return replace(result, remarks=(*result.remarks, told))
    name, row = far
    # What the master found out about the rest, as an instability, is about values that mean nothing.
    reason = _sentence(table, system, name, row, "far outside")
    kept = table.holding(table.values[: max(row, 1)])
    return replace(result, table=kept, status="stopped", reason=reason, error=None, remarks=())


def _with_cause(result: Result, system: Declared) -> Result:
    """A run that an FMU ended, with a remark on the input that is far from ordinary, if there is one."""
    cause = _cause(result.table, system, max(len(result.table) - 1, 0))
    return replace(result, remarks=(*result.remarks, cause)) if cause and len(result.table) else result


def _first(table: RecordTable, system: Declared, *, far: bool) -> tuple[str, int] | None:
    """Variable that is the first to be outside its band, or far outside, and the row in which it is."""
    found: list[tuple[int, str]] = []
    for name, scalar in system.bands.items():
        band = scalar.variable.plausible
        if band is None or name not in table:
            continue
        low, high = band.far if far else (band.low, band.high)
        column = np.asarray(table[name])
        outside = (column < low) | (column > high) | (~np.isfinite(column) if far else False)
        if outside.any():
            found.append((int(np.argmax(outside)), name))
    return (min(found)[1], min(found)[0]) if found else None


def _sentence(table: RecordTable, system: Declared, name: str, row: int, where: str) -> str:
    scalar = system.bands[name]
    band: Band = scalar.variable.plausible or Band(0.0, 0.0)
    low, high = (shown_in(scalar, value) for value in (band.low, band.high))
    value, time = float(table[name][row]), float(table.times[row])
    cause = _cause(table, system, row)
    because = "; ".join(each for each in (cause, band.why) if each)
    holds = f"what the model holds for ({low} to {high})"
    told = f"{name} is {shown_in(scalar, value)} at {time:g} s, {where} {holds}"
    return f"{told}; {because}" if because else told


def shown_in(scalar: Scalar, value: float) -> str:
    """A value in the unit in which people read it."""
    unit = scalar.variable.display or scalar.variable.unit
    read = conversion(parse_unit(scalar.variable.unit), parse_unit(unit))(value)
    return f"{read:.4g} {unit}"


def _cause(table: RecordTable, system: Declared, row: int) -> str:
    """The input from outside, or parameter, that is furthest from its ordinary size; empty if none is."""
    times, name, value, ordinary, unit = max(_sizes(table, system, row), default=(0.0, "", 0.0, 0.0, ""))
    return (
        f"{name} is {value:.4g} {unit}, ordinarily some {ordinary:.4g} {unit}" if times >= STANDS_OUT else ""
    )


def _sizes(table: RecordTable, system: Declared, row: int) -> Iterator[tuple[float, str, float, float, str]]:
    """How many times each input and parameter of the plant is off its ordinary size; name, both and unit."""
    for instance, component in system.components.items():
        if not component.inputs or not any(each.plausible for each in component.outputs):
            continue
        given = system.values.get(instance, {})
        for scalar in component.scalars():
            name, variable = f"{instance}.{scalar.name}", scalar.variable
            if isinstance(variable, Output) or scalar.is_temperature or scalar.is_discrete:
                continue
            value: Value | None = given.get(scalar.name)
            if isinstance(variable, Parameter):
                least = abs(scalar.start or 0.0)
                ordinary = least or variable.nominal or 0.0
            else:
                ordinary, least = variable.nominal or 0.0, 0.0
                if name in system.fed:
                    value = _from_outside(table, system, system.fed[name], row)
            if value is None or isinstance(value, str) or ordinary == 0:
                continue
            size = abs(float(value))
            times = max(size / ordinary, least / size if size else 0.0)
            yield times, name, float(value), ordinary, variable.unit


def _from_outside(table: RecordTable, system: Declared, source: str, row: int) -> float | None:
    """What an output gave in a row that depends on no other part, as a duty cycle's; None for others."""
    instance, _, variable = source.rpartition(".")
    giver, time = system.components.get(instance), table.times
    if giver is None or giver.inputs or row >= len(time):
        return None
    given = {n: float(v) for n, v in system.values.get(instance, {}).items() if not isinstance(v, str)}
    alone = Instance(giver)
    alone.set(given)
    alone.begin(float(time[row]))
    alone.initialize()
    return alone.get(variable)
