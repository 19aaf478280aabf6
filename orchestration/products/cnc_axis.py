"""What a law corrects in one axis as a line and a table over one temperature, and how close they are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.outcome import ClosedLoop
from warmlink.orchestration.replay.compare import run_over
from warmlink.orchestration.replay.logs import MeasuredLog

Array = NDArray[np.float64]

ROWS = 9
"""Rows of a table: a machine's control holds few, and growth bends little."""

SMOOTH = 1e-3
"""How much a table's bends count beside its errors: rows that no duty cycle reaches lie on a line."""

PLACES = ("base_position", "tip_position")
"""Parameters of a link: where it is held, and where it carries the tool."""

WHOLE = "1"
"""Name of the axis of a controller that no link is known of."""


@dataclass(frozen=True)
class Approximation:
    """How far a table and a line are off the law in a duty cycle, in m: rms and largest of either."""

    duty: str
    table: tuple[float, float]
    line: tuple[float, float]


@dataclass(frozen=True)
class TableOfAxis:
    """What a law corrects in one axis, by one temperature.

    Attributes
    ----------
    name : the link whose growth it is
    thermometer : the input of the law that the table goes by, as `tip_temperature`
    temperature, growth : of the table's rows, in K and m
    line : growth in m at 0 K by the straight line, and its slope in m/K
    places : where the link is held and where it carries the tool, in m; None if that is not known
    errors : for each duty cycle
    others : rms error in m of the straight line over each other thermometer
    """

    name: str
    thermometer: str
    temperature: Array
    growth: Array
    line: tuple[float, float]
    places: tuple[float, float] | None
    errors: tuple[Approximation, ...]
    others: Mapping[str, float]

    @property
    def largest(self) -> float:
        """Largest distance in m between table and law over the duty cycles."""
        return max(each.table[1] for each in self.errors)

    def rows(self) -> Iterator[tuple[float, float, float, float]]:
        """Temperature in K, offset in m, coefficient and position in m of each row.

        At a place P of the axis the correction is offset + coefficient (P - position).
        """
        for kelvin, growth in zip(self.temperature.tolist(), self.growth.tolist(), strict=True):
            if self.places is None:
                yield kelvin, growth, 0.0, 0.0
            else:
                base, tool = self.places
                yield kelvin, 0.0, growth / (tool - base), base


@dataclass(frozen=True)
class AxisRuns:
    """What a law corrected in one axis, in each run of duty cycles.

    Attributes
    ----------
    name : of the axis
    correction : in m, a vector for each run
    readings : in K by thermometer, a vector for each run
    places : as in `TableOfAxis`
    """

    name: str
    correction: Sequence[Array]
    readings: Mapping[str, Sequence[Array]]
    places: tuple[float, float] | None

    def tabulated(self, duties: Sequence[str], thermometer: str | None) -> TableOfAxis:
        """The table that is closest to the correction, by a thermometer or by the one that tells most."""
        every = np.concatenate(self.correction)
        lines = {each: _line(np.concatenate(kelvin), every) for each, kelvin in self.readings.items()}
        best = thermometer or min(lines, key=lambda each: lines[each][2])
        rows, growth = _rows(np.concatenate(self.readings[best]), every)
        start, slope, _ = lines[best]
        errors = tuple(
            Approximation(
                duty,
                _off(np.interp(kelvin, rows, growth) - correction),
                _off(start + slope * kelvin - correction),
            )
            for duty, kelvin, correction in zip(duties, self.readings[best], self.correction, strict=True)
        )
        order = sorted(lines, key=lambda each: lines[each][2])
        others = {each: lines[each][2] for each in order if each != best}
        return TableOfAxis(self.name, best, rows, growth, (start, slope), self.places, errors, others)


def axes_of(runs: Sequence[ClosedLoop]) -> list[AxisRuns]:
    """The axes of a machine: the links behind each of its controllers.

    Of a controller that corrects several links at once, each link gets what it adds to the score, and an
    equal share of what the law's correction differs from the sum.

    Raises InputError if no thermometer feeds a controller.
    """
    found = []
    for controller in runs[0].scenario.machine.controllers:
        readings = _readings(runs, controller)
        corrected = [np.asarray(each.table[f"{controller}.correction"]) for each in runs]
        links = _links(runs[0], controller)
        added = [[_added(each, link) for link in links] if len(links) > 1 else [] for each in runs]
        names = links or [controller.rpartition(".")[0] or WHOLE]
        for k, name in enumerate(names):
            own = [
                each[k] + (whole - sum(each)) / len(links) if each else whole
                for whole, each in zip(corrected, added, strict=True)
            ]
            found.append(AxisRuns(name, own, readings, _places(runs[0], name) if links else None))
    return found


def axis_of(law: Component, logs: Sequence[MeasuredLog]) -> AxisRuns:
    """What a law corrects over measured logs, in one axis of which no link is known.

    Rows in which a thermometer is missing are left out, those without it in all logs aside. Raises InputError
    if no thermometer changes, or the law refuses a parameter.
    """
    corrected, read = [], []
    for log in logs:
        inputs, outputs, _ = run_over(law, log)
        corrected.append(outputs.correction)
        read.append(inputs[:, [law.u.index[name] for name in SENSED]])
    every = np.concatenate(read)
    there = np.flatnonzero(np.isfinite(every).any(axis=0))
    used = [int(i) for i in there if np.ptp(every[np.isfinite(every[:, i]), i]) > 0.0]
    if not used:
        raise InputError("no thermometer changes in these logs; log one, as base_temperature [degC]")
    whole = [np.isfinite(each[:, used]).all(axis=1) for each in read]
    readings = {SENSED[i]: [each[rows, i] for each, rows in zip(read, whole, strict=True)] for i in used}
    corrected = [each[rows] for each, rows in zip(corrected, whole, strict=True)]
    return AxisRuns(WHOLE, corrected, readings, None)


def _readings(runs: Sequence[ClosedLoop], controller: str) -> dict[str, list[Array]]:
    """What each thermometer of a controller read in each run, in K; those that never change aside."""
    found = {}
    for name in SENSED:
        places = [each.scenario.machine.fed.get(f"{controller}.{name}", "") for each in runs]
        if all(place in each.table for place, each in zip(places, runs, strict=True)):
            read = [np.asarray(each.table[place]) for place, each in zip(places, runs, strict=True)]
            if np.ptp(np.concatenate(read)) > 0.0:
                found[name] = read
    if not found:
        raise InputError(
            f"no thermometer feeds {controller} in these duty cycles; wire one to it, as base_temperature"
        )
    return found


def _links(outcome: ClosedLoop, controller: str) -> list[str]:
    """Links that a controller corrects: those of its own group, as `axis3.link` of `axis3.compensator`."""
    group = controller.rpartition(".")[0]
    return [
        part
        for part, declared in outcome.scenario.declared.items()
        if {*PLACES} <= {v.name for v in declared.parameters} and part.rpartition(".")[0] == group
    ]


def _added(outcome: ClosedLoop, link: str) -> Array:
    """What the growth of a link alone adds to the score, in m."""
    score, growth = outcome.scenario.machine.roles.uncompensated, f"{link}.elongation"
    grown = np.asarray(outcome.table[growth])
    none = np.zeros(grown.shape)
    return np.asarray(
        score.value(lambda name: grown if name == growth else none) - score.value(lambda name: none)
    )


def _places(outcome: ClosedLoop, link: str) -> tuple[float, float] | None:
    """Where a link is held and carries the tool, in m."""
    declared = outcome.scenario.declared[link]
    given, start = outcome.scenario.values().get(link, {}), declared.p.values(declared.start_values()[0])
    base, tool = (float(np.asarray(given.get(each, start[each]), dtype=float)) for each in PLACES)
    return (base, tool) if tool > base else None


def _line(kelvin: Array, growth: Array) -> tuple[float, float, float]:
    """Growth at 0 K, slope, and rms error of the straight line closest to the growth."""
    middle = kelvin.mean()
    slope = float(np.mean((kelvin - middle) * (growth - growth.mean())) / max(np.var(kelvin), 1e-12))
    start = float(growth.mean() - slope * middle)
    return start, slope, float(np.sqrt(np.mean((start + slope * kelvin - growth) ** 2)))


def _rows(kelvin: Array, growth: Array) -> tuple[Array, Array]:
    """Rows of the table that is closest to the growth: linear in between, with few bends."""
    rows = np.linspace(kelvin.min(), kelvin.max(), ROWS)
    place = np.interp(kelvin, rows, np.arange(ROWS))
    left = np.minimum(place.astype(int), ROWS - 2)
    share = place - left
    normal, right = np.zeros((ROWS, ROWS)), np.zeros(ROWS)
    for k, a in ((left, 1.0 - share), (left + 1, share)):
        np.add.at(right, k, a * growth)
        for m, b in ((left, 1.0 - share), (left + 1, share)):
            np.add.at(normal, (k, m), a * b)
    bends = np.diff(np.eye(ROWS), 2, axis=0)
    whole = normal + SMOOTH * len(kelvin) * bends.T @ bends
    return rows, np.asarray(np.linalg.solve(whole, right), dtype=np.float64)


def _off(error: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
