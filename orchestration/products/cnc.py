"""A law as what a CNC's own compensation takes: lines and tables over thermometers, and one formula."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.texts import filled, parameters
from warmlink.controllers.interface import SENSED
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.component.units import display_conversion
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, several
from warmlink.orchestration.closed_loop.load import load_scenario, names_on
from warmlink.orchestration.closed_loop.outcome import ClosedLoop, run
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import fresh_folder, with_hash
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.products.cnc_axis import ROWS, TableOfAxis, axes_of, axis_of
from warmlink.orchestration.products.export import law_of
from warmlink.orchestration.replay.logs import read_logs, sources_in
from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO

if TYPE_CHECKING:
    from warmlink.orchestration.replay.logs import Logs


@dataclass(frozen=True, repr=False)
class CncTable(Answer):
    """A law as a line and a table over one temperature for each axis of the machine.

    Attributes
    ----------
    core : the law and its design
    axes : line and table of each axis
    duties : scenarios that they are close to the law in, with the hash of their files
    unit, temperature_unit : in which they are written
    formula : of a regression over all its thermometers; None for another law, or one for each axis
    measured : whether these are measured logs
    """

    core: Core
    axes: tuple[TableOfAxis, ...]
    duties: tuple[str, ...]
    unit: str
    temperature_unit: str
    formula: str | None
    measured: bool = False

    @property
    def name(self) -> str:
        """Name of the law."""
        return self.core.name

    @property
    def largest(self) -> float:
        """Largest distance in m between table and law over axes and duty cycles."""
        return max(each.largest for each in self.axes)

    def summary(self) -> str:
        """The table in a few lines."""
        axes = ", ".join(f"{each.name} over {each.thermometer}" for each in self.axes)
        told = f"{self.name}: {ROWS} rows for each axis, {axes}"
        return f"{told}; at most {self._length(self.largest):.3g} {self.unit} off the law"

    def _length(self, value: float) -> float:
        return value * display_conversion("m", self.unit)[0]

    def _warm(self, kelvin: float) -> float:
        factor, offset = display_conversion("K", self.temperature_unit)
        return factor * kelvin + offset

    def csv(self) -> str:
        """The tables: at a place P of an axis the correction is offset + coefficient (P - position)."""
        unit = self.unit
        lengths = f"offset [{unit}],coefficient [{unit}/m],position [m]"
        rows = [f"axis,thermometer,temperature [{self.temperature_unit}],{lengths},design"]
        for axis in self.axes:
            for kelvin, offset, coefficient, position in axis.rows():
                figures = (self._warm(kelvin), self._length(offset), self._length(coefficient), position)
                told = ",".join(f"{each:.6g}" for each in figures)
                rows.append(f"{axis.name},{axis.thermometer},{told},{self.core.mark}")
        return "\n".join((*rows, ""))

    def straight(self, axis: TableOfAxis) -> str:
        """The straight line of an axis as a formula."""
        factor = display_conversion("K", self.temperature_unit)[0]
        start, slope = axis.line
        zero = self._warm(-start / slope) if slope else 0.0
        sign = "-" if zero >= 0 else "+"
        told = f"{self._length(slope) / factor:.6g} * ({axis.thermometer} {sign} {abs(zero):.6g})"
        return f"correction = {told}"

    def write(self, folder: str | Path) -> None:
        """Write the table and a README into a folder, all or none; InputError if that is not possible."""
        with fresh_folder(Path(folder)) as scratch:
            (scratch / f"{self.name}.csv").write_text(self.csv(), encoding="utf-8")
            (scratch / "README.md").write_text(self.readme(), encoding="utf-8")

    def readme(self) -> str:
        """What the table is, how it is used, and how far it is off."""
        more = f"\nThe law itself in one line, over all its thermometers:\n\n    {self.formula}\n"
        return filled(
            self.core,
            "table_readme.txt",
            origin="\n".join(self.core.origin()),
            temperature=self.temperature_unit,
            unit=self.unit,
            axes="\n".join(self._axis(each) for each in self.axes),
            formula=more if self.formula else "",
            duties="\n".join(f"- {each}" for each in self.duties),
            what="measured logs" if self.measured else "duty cycles",
            by=_BY_LOGS if self.measured else _BY_MODEL,
            parameters=parameters(self.core),
        )

    def _axis(self, axis: TableOfAxis) -> str:
        """What there is to say of an axis."""
        rows = []
        for each in axis.errors:
            figures = (f"{self._length(value):.3g}" for value in (*each.table, *each.line))
            rows.append(f"| {each.duty} | {' | '.join(figures)} |")
        others = [f"- `{name}`: {self._length(off):.3g}" for name, off in axis.others.items()]
        return filled(
            self.core,
            "axis_readme.txt",
            axis=axis.name,
            thermometer=axis.thermometer,
            temperature=self.temperature_unit,
            unit=self.unit,
            straight=self.straight(axis),
            errors="\n".join(rows),
            others="\n".join(others) or "There are none.",
        )


_BY_LOGS = "This was computed from measured logs, without a model of the machine."
_BY_MODEL = "This was computed with warmlink's model of the machine, and is off by what that is."


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
    duties: Sequence[str] | str = (),
    data: Logs = (),
    thermometer: str | None = None,
    unit: str = "um",
    temperature: str = "degC",
) -> CncTable:
    """Approximate a law by what CNCs take: offset, coefficient and position by a temperature for each axis.

    The law runs in the closed loop of each duty cycle, or over measured logs; the table is the closest to
    what it corrects. An axis is a link; where one controller corrects several at once, the model says what
    each of them adds. Of logs no link is known: there is one axis, whose growth is all offset.

    Parameters
    ----------
    law : controller, as `observer`, or a law of one's own, as `my_law.py:MyLaw`
    design : parameter set (SSV) from `design`, or its values by name; the design that ships by default
    duties : scenarios of one machine, by name or file; by default those that ship for the cell
    data : logs of the machine (files or DataFrames) in place of scenarios, columns as `diagnose` reads them;
        no model of the machine is needed
    thermometer : one of the law's, as `tip_temperature`; by default for each axis the one that tells most
    unit : of lengths, as `um` or `mm`
    temperature : unit of temperatures, as `degC` or `K`

    Examples
    --------
    >>> wl.cnc_table("regression", duties=["stop_and_go"], unit="mm").write("cnc")
    >>> wl.cnc_table("regression", "law.ssv", data=["log.csv"]).write("cnc")

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
    duties, sources_given = several(duties), sources_in(data)
    if sources_given and duties:
        raise InputError(f"{argument('duty', duties[0])}: give either duty cycles or logs of the machine")
    if sources_given:
        logs = read_logs(sources_given)
        axes, played, one = [axis_of(component, logs)], [each.name for each in logs], True
        files = zip(sources_given, logs, strict=True)
        sources = [with_hash(of) if isinstance(of, (str, Path)) else log.name for of, log in files]
    else:
        scenarios = duties or names_on(load_scenario(DEFAULT_SCENARIO).machine.name)
        runs = _runs(law, component if design is not None else None, scenarios)
        axes, played = axes_of(runs), [each.scenario.name for each in runs]
        one = design is not None or runs[0].scenario.machine.designs is None
        sources = [with_hash(each) if Path(each).is_file() else f"{each}, as it ships" for each in scenarios]
    if all(np.abs(each).max() <= 0.0 for axis in axes for each in axis.correction):
        raise InputError(f"{name}: corrects nothing in these duty cycles; there is nothing to tabulate")
    for axis in axes:
        if thermometer is not None and thermometer not in axis.readings:
            told_so = f"{argument('thermometer', thermometer)}: no thermometer of the law"
            raise InputError(f"{told_so}; {instead(thermometer, axis.readings)}")
    tables = tuple(axis.tabulated(played, thermometer) for axis in axes)
    line = formula(component, unit, temperature) if one else None
    core = Core(component, name, "double", source)
    return CncTable(core, tables, tuple(sources), unit, temperature, line, bool(sources_given))


def _runs(law: str, designed: Component | None, scenarios: Sequence[str]) -> list[ClosedLoop]:
    """A law in the closed loop of scenarios of one machine; by the machine's own design if none is given."""
    given: dict[str, float] = {}
    if designed is not None:
        values = designed.start_values()[0].tolist()
        given = {f"{COMPENSATOR}.{n}": v for n, v in zip(designed.p.names, values, strict=True)}
    runs = [run(each, law, parameters=given) for each in scenarios]
    for other in runs[1:]:
        if other.scenario.machine.parts != runs[0].scenario.machine.parts:
            raise InputError(
                f"{argument('duty', other.scenario.name)}: is of another machine than "
                f"{runs[0].scenario.name}; give scenarios of one machine"
            )
    return runs
