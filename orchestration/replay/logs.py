"""Measured logs as laws see them: thermometers, duty and room, row by row, and the growth beside them.

The columns are those that `warmlink diagnose` reads, of any machine with one controller: its wires and roles
say which variable its law sees as which input, and which outputs add up to the growth. Where that is several,
a column `elongation` is what they add up to. A column `growth` is the truth: it is judged by and nothing is
learnt from it; without one, the growth that was measured is judged by.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.logs import Log
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.data.measured import Run, read_run
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.logged.layout import name_and_unit, plain

if TYPE_CHECKING:
    import pandas as pd

    Logs: TypeAlias = Iterable[str | Path | pd.DataFrame] | str | Path | pd.DataFrame

TRUTH, MEASURED = "growth", "elongation"
"""Columns of the growth: as it was, and as it was measured."""

DUTY = ("speed", "torque", "ambient_temperature")

SLOW_LOSSES = (300.0, 1800.0)
"""s over which losses are averaged that the rest may correlate with."""


@dataclass(frozen=True)
class MeasuredLog:
    """One log.

    Attributes
    ----------
    name : of its file
    time : in s from its start, shape (n,)
    signals : by the name of a law's input, in SI units, shapes (n,); NaN where there is no reading
    measured : growth in m where it was measured, else NaN, shape (n,)
    truth : growth in m in every row, if the log holds it
    """

    name: str
    time: Array
    signals: dict[str, Array]
    measured: Array
    truth: Array | None = None

    @property
    def reference_growth(self) -> Array:
        """Growth in m that errors count from, NaN where it is not known, shape (n,)."""
        return self.measured if self.truth is None else self.truth

    @cached_property
    def spacing(self) -> float:
        """Usual time in s from row to row."""
        return float(np.median(np.diff(self.time)))

    @property
    def learnt_from(self) -> Log:
        """What a law may learn from."""
        temperature = np.column_stack([self.signals[name] for name in SENSED])
        return Log(self.name, self.time, temperature, self.measured, self._others())

    def _others(self) -> dict[str, Array]:
        """Signals that what a law leaves may correlate with: duty, room, slow losses, and time."""
        found = {name: self.signals[name] for name in DUTY if np.isfinite(self.signals[name]).all()}
        for name, power in (("torque", 2), ("speed", 1)):
            for span in SLOW_LOSSES if name in found else ():
                what = "copper loss" if power == 2 else "friction"
                found[f"{what} of the last {span / 60:g} min"] = self._slow(
                    np.abs(found[name]) ** power, span
                )
        return found | {"time since the start": self.time}

    def _slow(self, signal: Array, span: float) -> Array:
        """A signal after a first-order filter with a time constant in s."""
        shares, slow = -np.expm1(-np.diff(self.time, prepend=self.time[0]) / span), signal.copy()
        for k in range(1, signal.size):
            slow[k] = slow[k - 1] + shares[k] * (signal[k] - slow[k - 1])
        return slow

    def inputs_of(self, law: Component, period: float) -> tuple[Array, Array, NDArray[np.intp]]:
        """What a law sees that samples each `period` seconds.

        Returns
        -------
        inputs : in the order of the law's inputs, each value held until the next, shape (m, u.size)
        measured : growth in m at the samples at which it was measured, else NaN, shape (m,)
        sample : number of the sample whose correction acts at each row of the log, shape (n,)
        """
        count = int(np.floor((self.time[-1] - self.time[0]) / period + 1e-9)) + 1
        samples = self.time[0] + period * np.arange(count)
        row = np.searchsorted(self.time, samples + 1e-9, side="right") - 1
        starts = dict(zip(law.u.names, law.start_values()[1].tolist(), strict=True))
        inputs = np.tile([starts[name] for name in law.u.names], (count, 1))
        for name, values in self.signals.items():
            inputs[:, law.u.index[name]] = values[row]
        seen = np.flatnonzero(np.isfinite(self.measured))
        sample = np.clip(np.searchsorted(samples, self.time - 1e-9), 0, count - 1)
        measured = np.full(count, np.nan)
        measured[sample[seen]] = self.measured[seen]
        acting = np.clip(np.searchsorted(samples, self.time + 1e-9, side="right") - 1, 0, count - 1)
        return np.asarray(inputs), measured, acting


def sources_in(logs: Logs) -> Sequence[str | Path | pd.DataFrame]:
    """The logs given, several or the only one."""
    return [logs] if isinstance(logs, str | Path) or hasattr(logs, "columns") else [*logs]


def read_logs(logs: Logs, options: ReadOptions = DEFAULT_OPTIONS) -> list[MeasuredLog]:
    """Read logs of one machine, of which each has a name of its own.

    Raises
    ------
    InputError
        A file, a header or a cell does not fit.
    """
    view, found, sources = law_view(rig_of(options.machine)), [], sources_in(logs)
    if not sources:
        raise InputError(f"{argument('data')}: there is no log; give a file of measurements, or several")
    for source in sources:
        place = Path(source) if isinstance(source, str) else source
        if isinstance(place, Path) and place.suffix.lower() == ".toml":
            raise InputError(f"{place}: is no log; give a file of measurements (CSV, text, Parquet, Excel)")
        found.append(_log(place, view, options))
    names = [each.name for each in found]
    taken = {name for name in names if names.count(name) == 1}
    for i, each in enumerate(found):
        if each.name in taken:
            continue
        numbered = (f"{each.name} ({number})" for number in count(i + 1))
        found[i] = replace(each, name=next(name for name in numbered if name not in taken))
        taken.add(found[i].name)
    return found


@dataclass(frozen=True)
class LawView:
    """What the law of a machine sees of it, and is to take out.

    Attributes
    ----------
    rig : the machine as it is measured
    inputs : variable of the rig by the law's input, as `base_temperature`; those alone that it is fed with
    growth : weights of the outputs that add up to the growth
    """

    rig: Rig
    inputs: Mapping[str, str]
    growth: Mapping[str, float]

    def signal(self, name: str, run: Run) -> Array:
        """Values of an input of the law in a run, in SI units; NaN where it was not logged."""
        variable = self.inputs.get(name, "")
        logged = {**run.inputs, **run.readings}
        found = (logged[each] for each in self.rig.fed_with(variable) if each in logged)
        return np.asarray(next(found, np.full(run.time.size, np.nan)), dtype=float)

    def measured(self, source: Path | pd.DataFrame, run: Run, options: ReadOptions) -> Array:
        """Growth in m as it was measured, NaN in rows where it was not; whole, or output by output."""
        if self.growth.keys() <= run.readings.keys():
            return np.asarray(sum(weight * run.readings[name] for name, weight in self.growth.items()))
        whole = self.column(MEASURED, source, run, options)
        return np.full(run.time.size, np.nan) if whole is None else whole

    def column(self, name: str, source: Path | pd.DataFrame, run: Run, options: ReadOptions) -> Array | None:
        """Growth in m of a column that says it whole, shape (n,); None if there is no such column."""
        headers = [each for each in run.unused if plain(name_and_unit(each)[0]) == name]
        if not headers:
            return None
        # Read in place of the first output that is a length.
        stand_in = next((each for each in self.growth if self.rig.unit(each) == "m"), None)
        if stand_in is None:
            raise InputError(
                f"{run.name}: column {headers[0]!r}: {self.rig.name} has no growth in m; leave it out"
            )
        names = {headers[0]: stand_in}
        names |= {column.header: "" for column in run.columns if column.variable in run.readings}
        again = read_run(source, self.rig, options=replace(options, names={**options.names, **names}))
        return np.asarray(np.interp(run.time, again.time, again.readings[stand_in]))


def law_view(rig: Rig) -> LawView:
    """What the law of a machine sees, by its wires and roles.

    InputError if the machine has no place for a controller, or several, or its score is no weighted sum.
    """
    machine = rig.machine
    if len(machine.controllers) != 1:
        raise InputError(
            f"{machine.name}: has {len(machine.controllers)} places for a controller, and a log shows what "
            "one law sees; give a machine with one"
        )
    if not machine.growth:
        raise InputError(f"{machine.name}: its score is no weighted sum of outputs, which a law could learn")
    (controller,) = machine.controllers
    driven = {name: rig.input_behind(f"{controller}.{name}") for name in DUTY}
    read = {name: rig.columns[name] for name in SENSED if name in rig.columns}
    return LawView(
        rig, {**{name: variable for name, variable in driven.items() if variable}, **read}, machine.growth
    )


def _log(source: Path | pd.DataFrame, view: LawView, options: ReadOptions) -> MeasuredLog:
    run = read_run(source, view.rig, options=options)
    for each in run.remarks:
        remark(each)
    signals = {name: view.signal(name, run) for name in (*SENSED, *DUTY)}
    truth = view.column(TRUTH, source, run, options)
    return MeasuredLog(run.name, run.time, signals, view.measured(source, run, options), truth)
