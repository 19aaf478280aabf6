"""Measured logs as laws see them: thermometers, duty and room, row by row, and the growth beside them.

The columns are those that `warmlink diagnose` reads. A column `growth` is the truth: it is judged by and
nothing is learnt from it; without one, the growth that was measured is judged by.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.logs import Log
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import remark
from warmlink.orchestration.diagnosis.data.columns import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.diagnosis.data.measured import Run, read_run
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.logged.layout import name_and_unit, plain

if TYPE_CHECKING:
    import pandas as pd

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


def read_logs(
    sources: Sequence[str | Path | pd.DataFrame], options: ReadOptions = DEFAULT_OPTIONS
) -> list[MeasuredLog]:
    """Read logs of one machine, of which each has a name of its own.

    Raises
    ------
    InputError
        A file, a header or a cell does not fit.
    """
    rig, found = rig_of(DEFAULT), []
    for source in sources:
        place = Path(source) if isinstance(source, str) else source
        if isinstance(place, Path) and place.suffix.lower() == ".toml":
            raise InputError(f"{place}: is no log; give a file of measurements (CSV, text, Parquet, Excel)")
        found.append(_log(place, rig, options))
    names = [each.name for each in found]
    return [
        each if names.count(each.name) == 1 else replace(each, name=f"{each.name} ({i})")
        for i, each in enumerate(found, 1)
    ]


def _log(source: Path | pd.DataFrame, rig: Rig, options: ReadOptions) -> MeasuredLog:
    run = read_run(source, rig, options=options)
    for each in run.remarks:
        remark(each)
    size = run.time.size
    variables = {column: variable for column, variable in rig.columns.items() if column != MEASURED}
    values = {**run.inputs, **run.readings}
    signals = {
        name: np.asarray(values.get(variables[name], np.full(size, np.nan)), dtype=float)
        for name in (*SENSED, *DUTY)
    }
    measured = np.asarray(run.readings.get(rig.columns[MEASURED], np.full(size, np.nan)))
    return MeasuredLog(run.name, run.time, signals, measured, _truth(source, rig, options, run))


def _truth(source: Path | pd.DataFrame, rig: Rig, options: ReadOptions, run: Run) -> Array | None:
    """The growth in m in every row, if the log has a column of that name."""
    headers = [each for each in run.unused if plain(name_and_unit(each)[0]) == TRUTH]
    if not headers:
        return None
    names = {headers[0]: MEASURED}
    names |= {c.header: "" for c in run.columns if c.variable == rig.columns[MEASURED]}
    whole = read_run(source, rig, options=replace(options, names={**options.names, **names}))
    growth = whole.readings[rig.columns[MEASURED]]
    return np.asarray(np.interp(run.time, whole.time, growth))
