"""Likely slips of whoever logged a run, which come before any cause.

A sign that is reversed, a log whose inputs come early or late, an input that was not logged while something
measured depends on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.clocks import shift
from warmlink.orchestration.diagnosis.data.experiment import Calibration, Experiment
from warmlink.orchestration.diagnosis.data.inputs import absent_drives, is_given
from warmlink.orchestration.diagnosis.data.measured import Run, names_of
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.system.units import ZERO_CELSIUS

_MOVES = {"K": 1.0, "m": 5e-6}
"""By how much, rms by SI unit, a reading and its simulation move at least, where they are compared."""

_REVERSED = -0.8
"""Correlation of a reading with its simulation below which its sign is reversed."""

_DEPENDS = 0.02
"""Change of a reading by that of an input from which it depends on it."""

_DRIFTS = 0.5
"""Share of a shift by which it differs between the halves of a run where one clock drifts."""

_SHOWS = 10.0
"""Change of a reading, as a multiple of how exact the simulation is, from which heat shows."""

_PAD = "pad_temperature"


@dataclass(frozen=True)
class Slips:
    """Sentences on what was probably not meant.

    `unlogged` are temperatures that act on what was measured and that nobody logged; `lacking` inputs that
    make heat and were not logged; `wrong` columns that are reversed, or early or late.
    """

    unlogged: tuple[str, ...] = ()
    lacking: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()

    @property
    def certain(self) -> tuple[str, ...]:
        """What is to be said whatever the model makes of the data."""
        return (*self.wrong, *self.unlogged)


def slips(experiment: Experiment) -> Slips:
    """Look for slips in the runs of an experiment, by its data and by its model as it stands."""
    lacking, wrong = absent_drives(experiment), list(_shifted(experiment))
    try:
        look = _Look(experiment, lacking)
        return Slips(tuple(look.unlogged()), tuple(look.lacking()), (*look.reversed(), *wrong))
    except NotSimulatedError:
        return Slips((), tuple(lacking.values()), tuple(wrong))


def _shifted(experiment: Experiment) -> Iterator[str]:
    names = names_of(experiment.columns)
    for run in experiment.runs:
        found, halves = _shift_of(experiment, run), list(_in_halves(experiment, run))
        first, second = (0.0 if each is None else each[0] for each in halves)
        if found is None:
            found = halves[1]
        if found is None:
            continue
        late, name = found
        word, other = ("late", "early") if late > 0 else ("early", "late")
        by, told = f"{abs(late):.0f} s", f"{_of(experiment, run)}{names[name]} follows the inputs"
        if late * second > 0 and abs(second) - abs(first) > _DRIFTS * abs(late) and first * second >= 0:
            ever, pace = ("later", "fast") if late > 0 else ("earlier", "slow")
            yield (
                f"{told} ever {ever}, by {abs(second):.0f} s in the second half of the run: "
                f"there are two clocks, and that of the readings runs {pace}; log both by one"
            )
        else:
            yield f"{told} {by} too {word}: they were logged {by} {other}, or by another clock; shift them"


def _in_halves(experiment: Experiment, run: Run) -> Iterator[tuple[float, str] | None]:
    """By how much the readings of each half of a run are late."""
    early = run.time < run.time[-1] / 2
    for part in (run.part(early), run.part(~early)):
        yield _shift_of(experiment, replace(part, time=part.time - part.time[0]))


def _shift_of(experiment: Experiment, run: Run) -> tuple[float, str] | None:
    unit = experiment.rig.unit
    heating = [each for name, signal in run.inputs.items() for each in _heating(name, signal, unit(name))]
    return shift(run, [name for name in run.readings if unit(name) == "K"], heating)


def _heating(name: str, signal: Array, unit: str) -> Iterator[Array]:
    """What of an input may make heat: its size and its square, and whether a pad is on."""
    if name.endswith(_PAD):
        parts = [np.isfinite(signal).astype(float)]
    else:
        size = np.abs(np.nan_to_num(signal))
        parts = [size, size**2] if unit != "K" else []
    yield from (each for each in parts if np.ptp(each) > 0)


def _of(experiment: Experiment, run: Run) -> str:
    return f"{run.name}: " if len(experiment.runs) > 1 else ""


class _Look:
    """The runs simulated as the model stands, with derivatives by temperatures that nobody logged.

    `lacking` are sentences by input that makes heat and that nobody logged.
    """

    def __init__(self, experiment: Experiment, lacking: Mapping[str, str]) -> None:
        self._experiment, rig, self._lacking = experiment, experiment.rig, lacking
        groups = {name for group in rig.required_inputs for name in group}
        self._free = [
            name
            for name in rig.externals
            if rig.variables[name].is_temperature
            and groups.isdisjoint(rig.fed_with(name))
            and not all(is_given(experiment, run, name) for run in experiment.runs)
        ]
        starts = [float(rig.variables[name].start or 0.0) for name in self._free]
        wide = [Calibration(n, s - 50, s + 50, s) for n, s in zip(self._free, starts, strict=True)]
        sizes = {name: float(rig.variables[name].variable.nominal or 1.0) for name in lacking}
        wide += [Calibration(name, -size, size, 0.0) for name, size in sizes.items()]
        stated = (*experiment.calibrated, *wide)
        self._problem = Problem(replace(experiment, calibrated=stated, declared=(), with_shipped=False))
        freed = self._problem.calibrated
        self._values = self._problem.values_by_run(freed, [each.start for each in freed])
        self._predicted = [self._problem.predict(i, z) for i, z in enumerate(self._values)]
        self._sizes = sizes

    def unlogged(self) -> Iterator[str]:
        """Temperatures that nobody logged and on which a reading depends."""
        rig, names = self._experiment.rig, list(self._problem.names.values())
        for name in self._free:
            slot = self._problem.slots.index(name)
            depends = np.max([np.nanmax(np.abs(by[:, :, slot]), axis=0) for _, by in self._predicted], axis=0)
            if depends.max() > _DEPENDS:
                taken = float(rig.variables[name].start or 0.0) - ZERO_CELSIUS
                yield (
                    f"{rig.column_of(name)} was not logged and is taken as {taken:g} degC, though "
                    f"{names[int(np.argmax(depends))]} depends on it: log it, or set the conductance to it "
                    "to 0 under [known]"
                )

    def lacking(self) -> Iterator[str]:
        """What nobody logged and makes heat, as far as the readings would show it."""
        for name, sentence in self._lacking.items():
            slot, shows = self._problem.slots.index(name), 0.0
            for i, z in enumerate(self._values):
                working = z.copy()
                working[slot] = self._sizes[name]
                change = self._problem.predict(i, working, ())[0] - self._predicted[i][0]
                shows = max(shows, float(np.nanmax(np.abs(change) / self._problem.floors)))
            if shows > _SHOWS:
                yield sentence

    def reversed(self) -> Iterator[str]:
        """Readings that fall where their simulation rises."""
        problem = self._problem
        for run, data, (simulated, _) in zip(
            self._experiment.runs, problem.data, self._predicted, strict=True
        ):
            for i, (variable, name) in enumerate(problem.names.items()):
                there = np.isfinite(data.readings[:, i] + simulated[:, i])
                pair = data.readings[there, i], simulated[there, i]
                moves = [float(np.std(each)) if each.size else 0.0 for each in pair]
                unit = problem.experiment.rig.unit(variable)
                if min(moves) > _MOVES.get(unit, np.inf):
                    alike = float(np.corrcoef(*pair)[0, 1])
                    if alike < _REVERSED:
                        falls = f"{_of(self._experiment, run)}{name} falls where it should rise"
                        told = f"{falls} (correlation with the simulation {alike:.2f})"
                        remedy = "look at the wires of its sensor"
                        if unit == "m":
                            remedy = "look at which way it counts as positive"
                        yield f"{told}: its sign is reversed; {remedy}"
