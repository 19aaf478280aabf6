"""An experiment made ready for fitting: thinned data, predictions, and the candidates for what is wrong."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.causes.catalogue import Cause, catalogue
from warmlink.orchestration.diagnosis.data.experiment import PER_RUN, Calibrated, Experiment
from warmlink.orchestration.diagnosis.data.measured import Run, names_of
from warmlink.orchestration.diagnosis.data.rig import ELONGATION
from warmlink.orchestration.diagnosis.data.thinning import Averaging, Thinned, thinned
from warmlink.orchestration.diagnosis.fit.candidates import INNER, freed_by
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.model.equations import equations
from warmlink.orchestration.diagnosis.model.forward import Courses, Forward
from warmlink.orchestration.diagnosis.model.grid import CHECK_CELLS, FINAL, SEARCH, Resolution
from warmlink.orchestration.diagnosis.model.initial import initial_values
from warmlink.orchestration.diagnosis.model.instruments import NEUTRAL, Readings

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Freed:
    """One number to be fitted.

    Attributes
    ----------
    variable : the FMU variable, or the first of several that share the value
    slots : indices of the variables that take the value
    runs : indices of the runs in which it acts
    lower, upper, start : bounds and starting value in SI; for a cause the start is the neutral value
    group : value of the label that it belongs to, "" for all
    calibrated : whether every model fits it, the uncorrected one included
    added : whether it is added to each variable's own value
    """

    variable: str
    slots: tuple[int, ...]
    runs: tuple[int, ...]
    lower: float
    upper: float
    start: float
    group: str = ""
    calibrated: bool = False
    added: bool = False

    @property
    def key(self) -> tuple[str, str, bool]:
        """Identifies the number in problems with other runs."""
        return self.variable, self.group, self.calibrated

    @property
    def span(self) -> float:
        """Size of an ordinary change, by which steps are scaled."""
        return self.upper - self.lower


@dataclass(frozen=True)
class Item:
    """A candidate: a cause, on one channel if it belongs to an instrument, and perhaps split by a label."""

    name: str
    cause: Cause
    freed: tuple[Freed, ...]
    label: str = ""

    @property
    def title(self) -> str:
        """Name with the label that splits it."""
        return f"{self.name} per {self.label}" if self.label else self.name


class Problem:
    """Everything that fits need.

    Attributes
    ----------
    experiment : what was measured
    variables : outputs that were measured, in order; the columns of predictions
    data : thinned readings by run
    calibrated : numbers that every model fits
    items : candidates
    """

    def __init__(self, experiment: Experiment) -> None:
        self.experiment = experiment
        self.variables = tuple(dict.fromkeys(column.variable for column in experiment.columns))
        self.names = names_of(experiment.columns)
        self.data: tuple[Thinned, ...] = tuple(thinned(run, self.variables) for run in experiment.runs)
        inner, outer = self._slots()
        self.slots = (*inner, *outer)
        self._inner, self._outer = inner, outer
        self._readings = self._simulated(SEARCH.cells, [SEARCH] * len(self.data), derivatives=True)
        self._corrections: list[Vector] = [np.zeros((d.time.size, len(self.variables))) for d in self.data]

    def predict(self, run: int, z: Vector) -> tuple[Vector, Vector]:
        """Readings of a run, shape (rows, outputs), and their derivatives, shape (rows, outputs, slots)."""
        values, by_slot = self._means(self._readings, run, z)
        return values + self._corrections[run], by_slot

    def finest(self, run: int, z: Vector) -> Vector:
        """Readings of a run without the grid's error, shape (rows, outputs)."""
        return self._means(self._finest, run, z)[0]

    @property
    def averaging(self) -> Averaging:
        """The averaging to which the stated noise refers: that of the first run to fit."""
        return self.data[self.fitted_runs[0] if self.fitted_runs else 0].averaging

    def noise_in(self, run: int, noise: Sequence[NoiseModel]) -> list[NoiseModel]:
        """Noise of each channel in a run, given that in the first run to fit."""
        return [model.averaged(self.data[run].averaging, self.averaging) for model in noise]

    def artefact(self, values: Sequence[Vector], noise: Sequence[NoiseModel]) -> float:
        """Error of the simulation's own steps and cells in standard deviations of all readings together.

        From a simulation of half the cells' size and half the steps, on the inputs as they were logged. Where
        the error might be taken for an effect, that finer one serves from here on.
        """
        total = 0.0
        finer = self._simulated(CHECK_CELLS, [each.forward for each in self._finest])
        for i, z in enumerate(values):
            error = self._means(finer, i, z)[0] - self.finest(i, z)
            sigma = np.array([each.white for each in self.noise_in(i, noise)])
            error = error[self.data[i].fitted] / sigma
            total += float(np.sum(error**2))
        if total > 1.0:
            self._finest = finer
        return float(np.sqrt(total))

    def refine(self, values: Sequence[Vector]) -> float:
        """Take the grid's error out at given values of the freed variables.

        Parameters
        ----------
        values : slots by run

        Returns
        -------
        float
            Largest error taken out, in units of 1 mK or 10 nm.
        """
        largest = 0.0
        for i, z in enumerate(values):
            error = self.finest(i, z) - self._means(self._readings, i, z)[0]
            self._corrections[i] = error
            scale = np.array([1e-8 if v == ELONGATION else 1e-3 for v in self.variables])
            largest = max(largest, float(np.abs(error / scale).max()))
        return largest

    def _means(self, readings: Sequence[Readings], run: int, z: Vector) -> tuple[Vector, Vector]:
        """Readings and derivatives as means over the blocks of rows that were averaged."""
        values, by_slot = readings[run](z)
        return self._mean(run, values), self._mean(run, by_slot)

    def _mean(self, run: int, each: Vector) -> Vector:
        weight = self.data[run].weight
        if weight.shape[1] == 1:
            return each
        return np.einsum("bpo,bpo...->bo...", weight, each.reshape(*weight.shape[:2], *each.shape[1:]))

    def responses(self, run: int, z: Vector, courses: Courses) -> Vector:
        """Derivatives of a run's readings by the values of courses, shape (rows, outputs, values)."""
        simulated = self._readings[run]
        inner = z[: len(self._inner)]
        return self._mean(run, simulated.forward.responses(inner, simulated.times, courses))

    def values(self, run: int, freed: Iterable[Freed], theta: Iterable[float]) -> Vector:
        """Slots of a run for fitted values; the later of two that share a slot counts."""
        z = self.neutral[run].copy()
        for parameter, value in zip(freed, theta, strict=True):
            if run in parameter.runs:
                slots = list(parameter.slots)
                z[slots] = z[slots] + value if parameter.added else value
        return z

    @cached_property
    def neutral(self) -> tuple[Vector, ...]:
        """Slots of each run where nothing is fitted."""
        outer = np.array([NEUTRAL.get(name, 0.0) for name in self._outer])
        return tuple(np.concatenate([r.forward.start_values(), outer]) for r in self._readings)

    @cached_property
    def fitted_runs(self) -> tuple[int, ...]:
        """Indices of the runs with rows to fit."""
        return tuple(i for i, d in enumerate(self.data) if d.fitted.any())

    @cached_property
    def calibrated(self) -> tuple[Freed, ...]:
        """Numbers that every model fits."""
        return tuple(freed for each in self.experiment.calibrated for freed in self._calibration(each))

    @cached_property
    def items(self) -> tuple[Item, ...]:
        """Candidates that this experiment's data and system allow.

        Where there is no motor, warmer air at the link is warmer air everywhere: such twins are offered once.
        """
        offered = (item for cause in catalogue() for item in self._items_of(cause))
        unlike: dict[tuple[object, ...], Item] = {}
        for item in offered:
            frees = tuple((f.slots, f.runs, f.lower, f.upper, f.start) for f in item.freed)
            unlike.setdefault((frees, item.label), item)
        return tuple(unlike.values())

    def _calibration(self, each: Calibrated) -> Iterable[Freed]:
        slot = (self.slots.index(each.variable),)
        for group, runs in self._groups(each.per):
            yield Freed(each.variable, slot, runs, each.lower, each.upper, each.start, group, True)

    def _items_of(self, cause: Cause) -> Iterable[Item]:
        for name, variables in freed_by(cause, self.experiment, self.names):
            slots = tuple(self.slots.index(v) for v in variables)
            also = next((c for c in self.experiment.calibrated if c.variable == variables[0]), None)
            # An instrument stays the same from run to run; what surrounds and covers the machine may not.
            labels = [
                "",
                *(self.experiment.cause_labels if cause.kind == "plant" and not cause.material else ()),
            ]
            for label in labels:
                groups = self._groups(label or None)
                if also is not None:
                    groups = groups[1:]  # the calibrated value serves the first group
                if not groups or (label and len(self._groups(label)) < 2):
                    continue
                freed = tuple(self._freed(cause, variables[0], slots, runs, g) for g, runs in groups)
                yield Item(name, cause, freed, label)

    def _freed(
        self, cause: Cause, variable: str, slots: tuple[int, ...], runs: tuple[int, ...], group: str
    ) -> Freed:
        nominal = float(self.neutral[runs[0]][slots[0]])
        lower, upper = cause.lower, cause.upper
        if cause.relative:
            lower, upper = lower * nominal, upper * nominal
        if variable.endswith("camera.offset"):
            lower, upper = lower * 1e-5, upper * 1e-5  # 1 K of a sensor is 10 um of the camera
        also = next((c for c in self.experiment.calibrated if c.variable == variable), None)
        if also is not None:
            lower, upper, nominal = also.lower, also.upper, also.start
        start = nominal if cause.neutral is None else cause.neutral
        return Freed(variable, slots, runs, lower, upper, start, group, added=cause.added)

    def _groups(self, label: str | None) -> list[tuple[str, tuple[int, ...]]]:
        """Runs by the value of a label; every run where there is none."""
        runs = range(len(self.experiment.runs))
        if label is None:
            return [("", tuple(runs))]
        if label == PER_RUN:
            return [(self.experiment.runs[i].name, (i,)) for i in runs]
        values = dict.fromkeys(self.experiment.runs[i].labels[label] for i in (*self.fitted_runs, *runs))
        return [(v, tuple(i for i in runs if self.experiment.runs[i].labels[label] == v)) for v in values]

    def _slots(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        inner = [c.variable for c in self.experiment.calibrated]
        outer: list[str] = []
        for cause in catalogue():
            for _, variables in freed_by(cause, self.experiment, self.names):
                (inner if cause.kind in INNER else outer).extend(variables)
        return tuple(dict.fromkeys(inner)), tuple(dict.fromkeys(outer))

    @cached_property
    def _finest(self) -> list[Readings]:
        return self._simulated(FINAL.cells, [FINAL] * len(self.data))

    def _simulated(
        self, cells: int, grids: Sequence[Resolution | Forward], derivatives: bool = False
    ) -> list[Readings]:
        """Readings of each run, simulated on the grid for that run."""
        compiled = equations(self.experiment.rig.name, cells, self._inner, self.variables)
        return [
            Readings(
                Forward(compiled, run, self.known_of(run), grid, derivatives),
                self.variables,
                self._outer,
                data.within.ravel(),
                _ambient(run, self.known_of(run)),
            )
            for run, data, grid in zip(self.experiment.runs, self.data, grids, strict=True)
        ]

    def known(self, run: int) -> Mapping[str, float]:
        """Known values of a run and its initial states, in SI."""
        return self.known_of(self.experiment.runs[run])

    def known_of(self, run: Run) -> Mapping[str, float]:
        """Known values of any run on the system and its initial states, in SI."""
        known = {**self.experiment.known, **run.known}
        if self.experiment.initial_measured:
            known = {**initial_values(self.experiment.rig, run, known), **known}
        return known


def _ambient(run: Run, known: Mapping[str, float]) -> tuple[Vector, Vector]:
    """Times in s and logged ambient temperature in K by row, which the sensors' stems are exposed to."""
    if run.ambient is not None:
        return run.time, run.ambient
    given = [value for name, value in known.items() if name.endswith(".ambient_temperature")]
    return run.time, np.full(run.time.size, given[0] if given else 295.15)
