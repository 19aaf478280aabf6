"""States at the start from the first minute of measurements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.thermal_link.equations import SENSORS, sensor_positions
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.rig import Rig

FIRST = 60.0
"""s whose readings are averaged."""

_ENOUGH, _CLEARLY = 5, 4.0
"""Readings that make a line, and standard errors of its slope that make it clear."""


def initial_values(rig: Rig, run: Run, known: Mapping[str, float]) -> dict[str, float]:
    """Values of the parameters that set the initial temperatures, in SI.

    Along the link they are linear between the sensors; what was not measured takes the mean of what was.
    """
    early = run.time <= FIRST
    first = {}
    for variable, values in run.readings.items():
        readings = values[early & np.isfinite(values)]
        if readings.size and rig.unit(variable) == "K":
            first[variable] = _at_start(run.time[early & np.isfinite(values)], readings)
    if not first:
        return {}
    mean = float(np.mean(list(first.values())))
    result: dict[str, float] = {}
    for motor in rig.called("motor"):
        shaft = first.get(f"{motor}.shaft_temperature", first.get(f"{motor}.winding_temperature", mean))
        result[f"{motor}.initial_shaft_temperature"] = shaft
        result[f"{motor}.initial_winding_temperature"] = first.get(f"{motor}.winding_temperature", shaft)
    at = {rig.on_link(variable): start for variable, start in first.items()}
    for link in rig.called("link"):
        here = {place[1]: start for place, start in at.items() if place and place[0] == link}
        result |= _along_link(rig, link, here, mean, known)
    for heater in rig.called("heater"):
        result[f"{heater}.initial_temperature"] = mean
    return result


def _at_start(times: NDArray[np.float64], readings: NDArray[np.float64]) -> float:
    """Mean of the first minute; where readings clearly rise or fall in it, their line at 0 s."""
    mean = float(np.mean(readings))
    if readings.size < _ENOUGH:
        return mean
    centred = times - times.mean()
    slope = float(centred @ readings / (centred @ centred))
    scatter = float(np.std(readings - mean - slope * centred, ddof=2))
    error = scatter / float(np.sqrt(centred @ centred))
    return mean - slope * float(times.mean()) if abs(slope) > _CLEARLY * error else mean


def _along_link(
    rig: Rig, link: str, measured: Mapping[int, float], mean: float, known: Mapping[str, float]
) -> dict[str, float]:
    component = rig.components[link]
    start = float(np.mean(list(measured.values()))) if measured else mean
    if "sensor_position[1]" not in component.p.index:  # a reduced link's are in its shape
        rises = [measured.get(i, start) - start for i in range(1, SENSORS + 1)]
        return _starting(link, start, rises)
    starts = [known.get(f"{link}.{n}", rig.variables[f"{link}.{n}"].start) for n in component.p.names]
    places = np.array(sensor_positions(component.p.read(np.array(starts, dtype=float))), dtype=float)
    if measured:
        order = sorted(measured, key=lambda i: places[i - 1])
        there = np.interp(places, [places[i - 1] for i in order], [measured[i] for i in order])
    else:
        there = np.full(SENSORS, start)
    return _starting(link, start, there - start)


def _starting(link: str, start: float, rises: Iterable[float]) -> dict[str, float]:
    named = {f"{link}.initial_temperature_rise[{i}]": float(rise) for i, rise in enumerate(rises, 1)}
    return {f"{link}.initial_temperature": start, **named}
