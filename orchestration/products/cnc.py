"""A law as what a CNC's own compensation takes: a line and a table over one thermometer, and one formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.texts import filled
from warmlink.controllers.interface import SENSED
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.component.units import display_conversion
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.closed_loop.load import load_scenario, names_on
from warmlink.orchestration.closed_loop.outcome import ClosedLoop, run
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.products.export import law_of
from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO

Array = NDArray[np.float64]

ROWS = 9
"""Rows of a table: a machine's control holds few, and growth bends little."""

SMOOTH = 1e-3
"""How much a table's bends count beside its errors: rows that no duty cycle reaches lie on a line."""

PLACES = ("base_position", "tip_position")
"""Parameters of a link: where it is held, and where it carries the tool."""


@dataclass(frozen=True)
class Approximation:
    """How far a table and a line are off the law in a duty cycle, in m: rms and largest of either."""

    duty: str
    table: tuple[float, float]
    line: tuple[float, float]


@dataclass(frozen=True, repr=False)
class CncTable(Answer):
    """A law as a line and a table over one temperature of the machine.

    Attributes
    ----------
    core : the law and its design
    axis : the link whose growth it is
    thermometer : the input of the law that the table goes by, as `tip_temperature`
    temperature, growth : of the table's rows, in K and m
    line : growth in m at 0 K by the straight line, and its slope in m/K
    places : where the link is held and where it carries the tool, in m; None where the machine has no such
    errors : for each duty cycle
    others : rms error in m of the straight line over each other thermometer
    unit, temperature_unit : in which they are written
    """

    core: Core
    axis: str
    thermometer: str
    temperature: Array
    growth: Array
    line: tuple[float, float]
    places: tuple[float, float] | None
    errors: tuple[Approximation, ...]
    others: Mapping[str, float]
    unit: str
    temperature_unit: str

    @property
    def name(self) -> str:
        """Name of the law."""
        return self.core.name

    @property
    def largest(self) -> float:
        """Largest distance in m between table and law over the duty cycles."""
        return max(each.table[1] for each in self.errors)

    def summary(self) -> str:
        """The table in a few lines."""
        told = f"{self.name}: {len(self.growth)} rows over {self.thermometer}"
        return f"{told}; at most {self._length(self.largest):.3g} {self.unit} off the law"

    def _length(self, value: float) -> float:
        return value * display_conversion("m", self.unit)[0]

    def _warm(self, kelvin: float) -> float:
        factor, offset = display_conversion("K", self.temperature_unit)
        return factor * kelvin + offset

    def csv(self) -> str:
        """The table: at a place P of the axis the correction is offset + coefficient (P - position)."""
        unit = self.unit
        lengths = f"offset [{unit}],coefficient [{unit}/m],position [m]"
        rows = [f"axis,{self.thermometer} [{self.temperature_unit}],{lengths}"]
        for kelvin, growth in zip(self.temperature, self.growth, strict=True):
            offset, coefficient, position = self._length(growth), 0.0, 0.0
            if self.places is not None:
                position, end = self.places
                offset, coefficient = 0.0, self._length(growth) / (end - position)
            rows.append(f"{self.axis},{self._warm(kelvin):.6g},{offset:.6g},{coefficient:.6g},{position:.6g}")
        return "\n".join((*rows, ""))

    @property
    def straight(self) -> str:
        """The straight line as a formula."""
        factor = display_conversion("K", self.temperature_unit)[0]
        slope = self._length(self.line[1]) / factor
        zero = self._warm(-self.line[0] / self.line[1]) if self.line[1] else 0.0
        sign = "-" if zero >= 0 else "+"
        return f"correction = {slope:.6g} * (T {sign} {abs(zero):.6g})"

    @property
    def formula(self) -> str | None:
        """The formula of a regression over all its thermometers; None for another law."""
        return formula(self.core.component, self.unit, self.temperature_unit)

    def write(self, folder: str | Path) -> None:
        """Write the table and a README into a folder, all or none; InputError if that is not possible."""
        with fresh_folder(Path(folder)) as scratch:
            (scratch / f"{self.name}.csv").write_text(self.csv(), encoding="utf-8")
            (scratch / "README.md").write_text(self.readme(), encoding="utf-8")

    def readme(self) -> str:
        """What the table is, how it is used, and how far it is off."""
        rows = []
        for each in self.errors:
            figures = (f"{self._length(value):.3g}" for value in (*each.table, *each.line))
            rows.append(f"| {each.duty} | {' | '.join(figures)} |")
        more = f"\nThe law itself in one line, over all its thermometers:\n\n    {self.formula}\n"
        return filled(
            self.core,
            "table_readme.txt",
            origin="\n".join(self.core.origin()),
            thermometer=self.thermometer,
            temperature=self.temperature_unit,
            unit=self.unit,
            straight=self.straight,
            formula=more if self.formula else "",
            errors="\n".join(rows),
            others="\n".join(f"- `{name}`: {self._length(off):.3g}" for name, off in self.others.items()),
        )


def formula(component: Component, unit: str, temperature_unit: str) -> str | None:
    """A regression in one line, in a unit of length, over temperatures; None for a law of another form."""
    start = component.p.values(component.start_values()[0])
    if not {"intercept", "coefficients", "reference_temperature"} <= start.keys():
        return None
    scale = display_conversion("m", unit)[0]
    factor, offset = display_conversion("K", temperature_unit)
    zero = factor * float(start["reference_temperature"]) + offset
    terms = [f"{scale * float(start['intercept']):.6g}"]
    for name, value in zip(SENSED, start["coefficients"], strict=True):
        if value:
            sign = "-" if zero >= 0 else "+"
            terms.append(f"{scale * float(value) / factor:.6g} * ({name} {sign} {abs(zero):.6g})")
    return "correction = " + " + ".join(terms).replace("+ -", "- ")


def cnc_table(
    law: str,
    design: str | Path | Mapping[str, str | float] | None = None,
    *,
    duties: Sequence[str] = (),
    thermometer: str | None = None,
    unit: str = "um",
    temperature: str = "degC",
) -> CncTable:
    """Approximate a law by what CNCs take: offset, coefficient and position by one temperature.

    The law runs in the closed loop of each duty cycle; the table is the closest to what it corrects.

    Parameters
    ----------
    law : controller, as `observer`, or a law of one's own, as `my_law.py:MyLaw`
    design : parameter set (SSV) from `design`, or its values by name; the design that ships by default
    duties : scenarios of one machine, by name or file; by default those that ship for the cell
    thermometer : one of the law's, as `tip_temperature`; by default the one that tells most
    unit : of lengths, as `um` or `mm`
    temperature : unit of temperatures, as `degC` or `K`

    Examples
    --------
    >>> wl.cnc_table("regression", duties=["stop_and_go"], unit="mm").write("cnc")

    Raises
    ------
    InputError
        If there is no such law, scenario, temperature or unit, or the law corrects nothing in them.
    """
    for argued, of, asked in (("unit", "m", unit), ("temperature", "K", temperature)):
        try:
            display_conversion(of, asked)
        except ValueError:
            what = "a length; give one as um or mm" if of == "m" else "a temperature; give one as degC or K"
            raise InputError(f"{argument(argued, asked)}: is no unit of {what}") from None
    name, component, source = law_of(law, design)
    values = component.start_values()[0].tolist()
    told = {f"{COMPENSATOR}.{n}": v for n, v in zip(component.p.names, values, strict=True)}
    given = told if design is not None else {}
    runs = [
        run(each, law, parameters=given)
        for each in duties or names_on(load_scenario(DEFAULT_SCENARIO).machine.name)
    ]
    grown = [_correction(each) for each in runs]
    every = np.concatenate(grown)
    if np.abs(every).max() <= 0.0:
        raise InputError(f"{name}: corrects nothing in these duty cycles; there is nothing to tabulate")
    read = _readings(runs)
    if thermometer is not None and thermometer not in read:
        told_so = f"{argument('thermometer', thermometer)}: no thermometer of the law"
        raise InputError(f"{told_so}; {instead(thermometer, read)}")
    lines = {each: _line(np.concatenate(kelvin), every) for each, kelvin in read.items()}
    best = thermometer or min(lines, key=lambda each: lines[each][2])
    rows, growth = _rows(np.concatenate(read[best]), every)
    start, slope, _ = lines[best]
    errors = tuple(
        Approximation(
            each.scenario.name,
            _off(np.interp(kelvin, rows, growth) - correction),
            _off(start + slope * kelvin - correction),
        )
        for each, kelvin, correction in zip(runs, read[best], grown, strict=True)
    )
    others = {each: lines[each][2] for each in sorted(lines, key=lambda each: lines[each][2]) if each != best}
    axis, places = _places(runs[0])
    core = Core(component, name, "double", source)
    line = start, slope
    return CncTable(core, axis, best, rows, growth, line, places, errors, others, unit, temperature)


def _correction(outcome: ClosedLoop) -> Array:
    return np.asarray(outcome.table[f"{COMPENSATOR}.correction"])


def _readings(runs: Sequence[ClosedLoop]) -> dict[str, list[Array]]:
    """What each thermometer of the law read in each run, in K; those that never change aside."""
    found = {}
    for name in SENSED:
        places = [each.scenario.machine.fed.get(f"{COMPENSATOR}.{name}", "") for each in runs]
        if all(place in each.table for place, each in zip(places, runs, strict=True)):
            read = [np.asarray(each.table[place]) for place, each in zip(places, runs, strict=True)]
            if np.ptp(np.concatenate(read)) > 0.0:
                found[name] = read
    if not found:
        raise InputError("no thermometer feeds the controller in these duty cycles; wire one to it")
    return found


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


def _places(outcome: ClosedLoop) -> tuple[str, tuple[float, float] | None]:
    """The link, and where it is held and carries the tool, in m; None where no one link says so."""
    held = {
        part: declared
        for part, declared in outcome.scenario.declared.items()
        if {*PLACES} <= {v.name for v in declared.parameters}
    }
    if len(held) != 1:
        return "1", None
    ((part, declared),) = held.items()
    given, start = outcome.scenario.values().get(part, {}), declared.p.values(declared.start_values()[0])
    base, tool = (float(np.asarray(given.get(each, start[each]), dtype=float)) for each in PLACES)
    return part, (base, tool) if tool > base else None
