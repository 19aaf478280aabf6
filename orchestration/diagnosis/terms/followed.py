"""Variables that terms may follow, as logged or measured in each run, and the heat of a term."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from warmlink.fmus.heat_term.law import FUNCTIONS, PlainNumber, power
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.baselines import filtered
from warmlink.orchestration.diagnosis.model.simulation import input_table
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.diagnosis.terms.modelled import named


class TermSignals:
    """Variables that terms may follow in the runs of a problem.

    Parameters
    ----------
    problem : the runs, and the simulation that fills what was not read
    values : of all slots by run, as the model stands
    """

    def __init__(self, problem: Problem, values: Sequence[Array]) -> None:
        self._problem, self._values = problem, values
        self._courses: dict[tuple[str, tuple[float, ...]], list[Array]] = {}

    def _logged(self, measured: Run) -> dict[str, Array]:
        """Inputs of a run by the name that a form has for them."""
        rig = self._problem.experiment.rig
        table = input_table(rig, measured, self._problem.known(measured))
        inputs = dict(zip(rig.externals, table, strict=True))
        found = {name: inputs[full] for name, full in named(rig).items() if full in inputs}
        return {name: values for name, values in found.items() if np.isfinite(values).all()}

    def logged(self, experiment: Experiment) -> list[dict[str, Array]]:
        """Inputs of all runs, held-out rows included, whose levels a switch may lie between."""
        return [self._logged(run) for run in experiment.runs]

    @cached_property
    def signals(self) -> list[dict[str, Array]]:
        """Variables that a form may follow, in SI, at the rows of each run: logged or measured."""
        found = []
        for run, measured in enumerate(self._problem.experiment.runs):
            here = self._logged(measured)
            for name, full in named(self._problem.experiment.rig).items():
                if full in self._problem.variables:
                    here[name] = self._read(run, self._problem.variables.index(full))
            here["speed"] = np.abs(here["speed"]) if "speed" in here else np.zeros(measured.time.size)
            found.append(here)
        shared = set.intersection(*(set(each) for each in found)) - {"pad_temperature", "pad_mode"}
        return [{name: each[name] for name in sorted(shared)} for each in found]

    @cached_property
    def on_fitted_rows(self) -> Mapping[str, Array]:
        """The same on the rows of all runs that are fitted, one after another."""
        runs = zip(self._problem.experiment.runs, self.signals, strict=True)
        every = [{name: values[run.fitted] for name, values in signals.items()} for run, signals in runs]
        return {name: np.concatenate([each[name] for each in every]) for name in every[0]}

    def _read(self, run: int, channel: int) -> Array:
        """A measured temperature at a run's rows, and what the model says where nothing is read."""
        data, rows = self._problem.data[run], self._problem.experiment.runs[run].time
        simulated = self._problem.predict(run, self._values[run], ())[0][:, channel]
        values = data.readings[:, channel]
        good = np.isfinite(values) & data.fitted
        off = np.interp(data.time, data.time[good], (values - simulated)[good]) if good.any() else 0.0
        return np.interp(rows, data.time, simulated + off)

    def course(self, candidate: Candidate) -> list[Array]:
        """Heat of a candidate of 1 W at the rows of each run, shape (rows,)."""
        key = candidate.form.heat, candidate.shape
        if key not in self._courses:
            self._courses[key] = [self._course(run, candidate) for run in range(len(self.signals))]
        return self._courses[key]

    def _course(self, run: int, candidate: Candidate) -> Array:
        time = self._problem.experiment.runs[run].time
        shape = zip(candidate.form.shapes, candidate.shape, strict=True)
        values: dict[str, float | Array] = {
            "a": 1.0,
            **{name: value for name, (value, _) in candidate.fixed.items()},
            **{each.name: value for each, value in shape},
            **self.signals[run],
            "time": time,
        }

        def lag(follows: Array, constant: float) -> Array:
            table = np.broadcast_to(np.asarray(follows, dtype=float), time.shape)[:, None]
            # A row holds until the next one, and what is followed is that of the row before.
            held = np.vstack([table[:1], table[:-1]])
            return filtered(time, held, float(constant))[:, 0]

        functions = {**FUNCTIONS, "lag": (2, lag)}
        with np.errstate(all="ignore"):
            found = candidate.form.law.in_arithmetic(values.__getitem__, functions, power, PlainNumber)
        return np.nan_to_num(np.broadcast_to(np.asarray(found, dtype=float), time.shape))
