"""What a column looks like where it is not what its header says: stuck, in another unit, or swapped.

A hint, not a finding, and the data stay as they are. It is judged by the simulation as it stands.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.machine.rig import SCALE
from warmlink.orchestration.system.units import parse_unit

_BETTER = 3.0
"""Times less that the simulation is off, from which a column is said to be something else."""

_MOVES, _SHARE = {"K": 1.0, "m": 5e-6}, 0.1
"""Change in the simulation, rms by SI unit, that a reading should show, and what share of it is little."""

_LEVEL = 10
"""Rows of one value from which on it is asked whether the sensor is stuck."""

_MISTAKEN = {
    "K": ("degC", "degF", "K"),
    "m": ("um", "mm", "m"),
    "rad/s": ("rad/s", "rpm", "deg/s"),
    "N.m": ("N.m", "N.mm", "kN.m"),
    "A": ("A", "mA"),
    "W": ("W", "mW", "kW"),
}
"""Units that are taken for each other, by SI unit."""


def doubts(problem: Problem, values: Sequence[Array]) -> tuple[str, ...]:
    """Sentences on columns of each run; `values` are the slots by run of the model as it stands."""
    named = [f"{run.name}: " if len(values) > 1 else "" for run in problem.experiment.runs]
    found = [_Doubts(problem, run, z).sentences() for run, z in enumerate(values)]
    return tuple(name + each for name, said in zip(named, found, strict=True) for each in said)


def doubts_of(assessment: Assessment) -> tuple[str, ...]:
    """The same by the uncorrected model of an assessment, on the rows that were fitted."""
    problem, null = assessment.problem, assessment.null
    return doubts(problem, problem.values_by_run(null.freed, null.theta))


def before_diagnosis(experiment: Experiment) -> tuple[str, ...]:
    """What columns look like, by the model before anything is fitted, or why they cannot be diagnosed."""
    try:
        refuse_senseless(experiment)
        problem = Problem(experiment)
        freed = problem.calibrated
        return doubts(problem, problem.values_by_run(freed, [each.start for each in freed]))
    except NotSimulatedError:
        return ()
    except InputError as fault:
        return (f"a diagnosis refuses this: {fault}",)


class _Doubts:
    """Looks at the columns of one run of a problem, which is simulated with `z`."""

    def __init__(self, problem: Problem, run: int, z: Array) -> None:
        self._problem, self._run, self._z = problem, run, z
        readings, quantum = problem.data[run].readings, problem.data[run].quantum
        self._there = np.flatnonzero(np.isfinite(readings).any(axis=0))
        self._measured, self._quantum = readings[:, self._there], quantum[self._there]
        self._simulated = self._with({})
        variables = [problem.variables[i] for i in self._there.tolist()]
        self._names = [problem.names[variable] for variable in variables]
        self._units = [problem.experiment.rig.unit(variable) for variable in variables]
        written = {column.variable: column.unit for column in problem.experiment.runs[run].columns}
        self._written = [written[variable] for variable in variables]

    def sentences(self) -> tuple[str, ...]:
        """Say which columns look like something else, and like what; an input alone if it explains all."""
        if inputs := tuple(self._inputs_in_other_units()):
            return inputs
        stuck = dict(self._stuck())
        if 1 < len(stuck) >= len(self._names) / 2:
            stuck = {}  # no sensor is to blame where half of them move too little
        said = {**stuck, **dict(self._in_other_units())}
        return (*said.values(), *self._swapped([i for i in range(len(self._names)) if i not in said]))

    def _with(self, given: Mapping[str, float]) -> Array:
        """Simulated readings with other values of some slots, infinite where these cannot be simulated."""
        changed = self._z.copy()
        for name, value in given.items():
            changed[self._problem.slots.index(name)] = value
        try:
            return self._problem.predict(self._run, changed, ())[0][:, self._there]
        except NotSimulatedError:
            return np.full(self._measured.shape, np.inf)

    def _stuck(self) -> Iterator[tuple[int, str]]:
        """Readings that stay where they are, for a time or throughout, while the simulation moves."""
        for i, (name, unit) in enumerate(zip(self._names, self._units, strict=True)):
            read = np.flatnonzero(np.isfinite(self._measured[:, i] + self._simulated[:, i]))
            if unit in _MOVES and read.size:
                # Readings that are rounded stay where they are while they move by less than a step.
                least = max(_MOVES[unit] / 4, 2 * float(self._quantum[i]))
                level = read[_longest_level(self._measured[read, i])]
                stretches = ((level, least), (read, _MOVES[unit]))
                for rows, enough in (each for each in stretches if each[0].size >= _LEVEL):
                    shows, should = (float(np.std(v[rows, i])) for v in (self._measured, self._simulated))
                    if should > enough and shows < _SHARE * should:
                        told = f"by {_shown(shows, unit)} rms in {rows.size} of {read.size} rows"
                        told += f", the simulation by {_shown(should, unit)}"
                        yield i, f"{name} changes {told}: is the sensor connected, and in its place?"

    def _in_other_units(self) -> Iterator[tuple[int, str]]:
        """Readings that fit better in a unit other than that of their header."""
        for i, (name, unit, written) in enumerate(zip(self._names, self._units, self._written, strict=True)):
            own, as_it_is = _to_si(written), _rms(self._measured[:, i] - self._simulated[:, i])
            for other in _MISTAKEN.get(unit, ()):
                factor, offset = _to_si(other)
                read = (self._measured[:, i] - own[1]) / own[0] * factor + offset
                left = _rms(read - self._simulated[:, i])
                if left * _BETTER < as_it_is:
                    then = f"{_shown(left, unit)} instead of {_shown(as_it_is, unit)}"
                    told = f"{name} looks as if it were in {other}, not {written}"
                    yield i, f"{told}: then it is off by {then}."

    def _swapped(self, channels: Sequence[int]) -> Iterator[str]:
        """The two columns that gain most in each other's place, if any do."""
        found: list[tuple[float, str]] = []
        for one, two in combinations(channels, 2):
            if self._units[one] == self._units[two]:
                seen = self._simulated[:, [one, two]]
                as_they_are, swapped = (_rms(self._measured[:, p] - seen) for p in ([one, two], [two, one]))
                if swapped * _BETTER < as_they_are:
                    unit, names = self._units[one], f"{self._names[one]} and {self._names[two]}"
                    then = f"{_shown(swapped, unit)} instead of {_shown(as_they_are, unit)}"
                    told = f"{names} look swapped: then they are off by {then}."
                    found.append((as_they_are - swapped, told))
        yield from (told for _, told in sorted(found)[-1:])

    def _inputs_in_other_units(self) -> Iterator[str]:
        """The input that explains the most if its unit is not that of its header; None if there is none."""
        rig, found = self._problem.experiment.rig, []
        as_it_is = self._share(self._simulated)
        for column in self._problem.experiment.runs[self._run].columns if not rig.in_loop else ():
            slot = f"{SCALE}:{column.variable}"
            if slot in self._problem.slots:
                for other in _MISTAKEN.get(rig.unit(column.variable), ()):
                    share = self._share(self._with({slot: _to_si(other)[0] / _to_si(column.unit)[0]}))
                    if share * _BETTER < as_it_is and share < _SHARE:
                        told = f"{column.name} looks as if it were in {other}, not {column.unit}: then "
                        left = f"readings are off by {100 * share:.2g} % of what they change by."
                        found.append((share, told + left))
        yield from (told for _, told in sorted(found)[:1])

    def _share(self, simulated: Array) -> float:
        """Errors of all readings, as a share of what each changes by."""
        changes = np.nanstd(self._measured, axis=0)
        moving = changes > 0
        return _rms((self._measured - simulated)[:, moving] / changes[moving])


_MORE = 1.5
"""Times a stated noise by which readings scatter from row to row for it to be told."""


def understated(problem: Problem) -> tuple[str, ...]:
    """Sentences on columns that scatter by more from row to row than the noise that is stated of them."""
    said = []
    for i, (variable, name) in enumerate(problem.names.items()):
        stated, unit = problem.experiment.noise.get(variable), problem.experiment.rig.unit(variable)
        scatter = max(float(data.scatter[i]) for data in problem.data)
        if stated is not None and scatter > _MORE * stated:
            told = f"{name} scatters by {_shown(scatter, unit)} from row to row, more than the noise of "
            said.append(
                f"{told}{_shown(stated, unit)} that is stated: by this a model is hardly ever adequate."
            )
    return tuple(said)


def beyond_noise(assessment: Assessment, name: str, over: float) -> str:
    """Say that a model leaves so many times the noise in a column, which is stated or credible."""
    problem = assessment.problem
    variable = next(v for v, column in problem.names.items() if column == name)
    place, run = problem.variables.index(variable), problem.fitted_runs[0]
    unit, stated = problem.experiment.rig.unit(variable), problem.experiment.noise.get(variable)
    left = f"The model leaves {over:.2g} times the noise in {name}"
    if stated is not None:
        return f"{left}, of which {_shown(stated, unit)} is stated."
    scatter = float(problem.scatter_in(run)[place])
    return (
        f"{left}, which scatters by {_shown(scatter, unit)} from row to row: the rest may be slow noise or "
        f"the model's fault, which these rows do not tell; state the noise of {name}."
    )


def unchanging_inputs(experiment: Experiment) -> tuple[str, ...]:
    """Ask after inputs other than temperatures that never change while others do, which may be right."""
    runs, rig = experiment.runs, experiment.rig
    driven = (each for each in runs[0].columns if each.variable in runs[0].inputs)
    values = {
        column: np.concatenate([run.inputs[column.variable] for run in runs if column.variable in run.inputs])
        for column in driven
        if rig.unit(column.variable) != "K"
    }
    still = [column for column, each in values.items() if np.ptp(each) == 0]
    told = "in every row, while other inputs change: was it logged?"
    # A pad's power that is empty throughout is off.
    asked = tuple(f"{column.name} is {column.least or 0:g} {column.unit} {told}" for column in still)
    return asked if len(still) < len(values) else ()


def _longest_level(values: Array) -> slice:
    """Rows of the longest stretch in which values do not change; shape (rows,), without gaps."""
    edges = np.flatnonzero(np.abs(np.diff(values)) > 1e-9 * np.abs(values[1:])) + 1
    ends = np.array([0, *edges, values.size])
    longest = int(np.argmax(np.diff(ends)))
    return slice(int(ends[longest]), int(ends[longest + 1]))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.nanmean(values**2)))


def _to_si(unit: str) -> tuple[float, float]:
    """Factor and offset to SI."""
    known = parse_unit(unit)
    return known.factor, known.offset


def _shown(value: float, unit: str) -> str:
    """A difference in the unit in which people read it."""
    factor, shown = (1e6, "um") if unit == "m" else (1.0, unit)
    return f"{float(f'{round(factor * value, 6):.2g}'):g} {shown}"
