"""Predicted readings of an experiment's runs, with their derivatives by everything that may be freed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.thinning import ROW, Averaging
from warmlink.orchestration.diagnosis.fit.algebra import root_of
from warmlink.orchestration.diagnosis.fit.candidates import Candidates, FreeNumber
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.model.equations import equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.instruments import Readings, outputs_behind
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.loop import Loop
from warmlink.orchestration.diagnosis.model.simulation import (
    Simulation,
    given_inputs,
    input_table,
    parts_before,
)
from warmlink.orchestration.diagnosis.model.steps import CHECK_CELLS, FINAL, SEARCH, Resolution, leaps
from warmlink.orchestration.machine.rig import OFFSET

_SPACING, _MOST_NODES = 120.0, 120
"""s between the nodes of a broken line that stands for scatter, at least, and its stretches at most."""

_PARTS = 2
"""Of the time between two rows, in each of which a leap is simulated to come sooner; one more where the log
has gaps."""

_PAUSED = 1.2
"""Usual times between rows that a pause may last without its leaps coming sooner than all of them alike."""

_CREDIBLE = 4.0
"""Times the scatter from row to row that noise of an instrument, correlated over a minute, is at most."""

_AT_ONCE = 12
"""Leaps that are simulated together, at most: each takes memory for all states."""

_FLOORS = {"K": 1e-3, "m": 1e-8}
_SHARE, _LEAST = 1e-5, 1e-12
"""Floors by SI unit; of other units as a share of the readings' range, and at least."""


class Problem(Candidates):
    """Everything that fits need: readings of every run, simulated at any values of what may be freed."""

    def __init__(self, experiment: Experiment) -> None:
        super().__init__(experiment)
        self._until, self.ended_early = time.monotonic() + experiment.time_limit, False
        self._readings = self._simulated(SEARCH.cells, [SEARCH] * len(self.data), derivatives=True)
        nothing = tuple(np.zeros((d.time.size, len(self.variables))) for d in self.data)
        self._corrections: tuple[Array, ...] = nothing
        self._cells, self._beyond_finest = FINAL.cells, nothing
        self._refined_at = self.neutral

    def out_of_time(self) -> bool:
        """Whether a fit has to end where it is; `ended_early` remembers that one had to."""
        self.ended_early = self.ended_early or time.monotonic() > self._until
        return self.ended_early

    def predict(self, run: int, z: Array, by: Sequence[FreeNumber] | None = None) -> tuple[Array, Array]:
        """Readings of a run, shape (rows, outputs), and their derivatives, shape (rows, outputs, slots).

        They are by every slot, or else by those of some numbers and 0 by the others, which takes less time.
        """
        wanted = None if by is None else sorted({i for f in by if run in f.runs for i in f.slots})
        values, by_slot = (self._mean(run, each) for each in self._readings[run](z, wanted))
        if wanted is not None:
            found, by_slot = by_slot, np.zeros((*values.shape, z.size))
            by_slot[:, :, wanted] = found
        return values + self._corrections[run], by_slot

    def finest(self, run: int, z: Array) -> Array:
        """Readings of a run without the grid's error, shape (rows, outputs)."""
        return self._means(self._finest, run, z) + self._beyond_finest[run]

    @property
    def averaging(self) -> Averaging:
        """The averaging to which the stated noise refers: that of the first run to fit."""
        return self.data[self.fitted_runs[0] if self.fitted_runs else 0].averaging

    def noise_in(self, run: int, noise: Sequence[NoiseModel]) -> list[NoiseModel]:
        """Noise of each channel in a run, given that in the first run to fit."""
        return [model.averaged(self.data[run].averaging, self.averaging) for model in noise]

    def reported_noise(self, run: int, noise: Sequence[NoiseModel]) -> Array:
        """Noise in which a run's errors are reported and judged, by output in SI, shape (outputs,).

        What is stated rules. What is estimated from what models leave may be their own misfit, so that it
        counts as far as the readings' own scatter from row to row makes it credible.
        """
        data, result = self.data[run], []
        for i, (name, model) in enumerate(zip(self.variables, self.noise_in(run, noise), strict=True)):
            stated = self.experiment.noise.get(name)
            if stated is None:
                result.append(min(model.sigma, _CREDIBLE * self.scatter_in(run)[i]))
            else:
                result.append(
                    stated if model.lasting else NoiseModel(stated).averaged(data.averaging, ROW).sigma
                )
        return np.array(result)

    def scatter_in(self, run: int) -> Array:
        """White noise of a run's readings by their scatter from row to row, shape (outputs,)."""
        data = self.data[run]
        least = np.maximum(data.scatter, data.quantum / np.sqrt(12))
        averaged = [NoiseModel(white).averaged(data.averaging, ROW).sigma for white in least.tolist()]
        return np.maximum(averaged, self.floors)

    def deviations(self, run: int, noise: Sequence[NoiseModel]) -> Array:
        """Standard deviation of each reading's noise, that of leaps included, shape (rows, outputs)."""
        return np.sqrt(self.reported_noise(run, noise) ** 2 + np.sum(self.leaping[run] ** 2, axis=2))

    def artefact(self, values: Sequence[Array], noise: Sequence[NoiseModel]) -> float:
        """Error of the simulation's own steps and cells in standard deviations of all readings together.

        From a simulation of half the cells' size and half the steps, on the inputs as they were logged. Where
        the error might be taken for an effect, that finer one serves from here on.
        """
        total = 0.0
        finer = self._halved(CHECK_CELLS)
        for i, error in enumerate(self._changes(finer, values)):
            sigma = np.array([each.white for each in self.noise_in(i, noise)])
            total += float(np.sum((error[self.data[i].fitted] / sigma) ** 2))
        if total > 1.0:
            self._finest, self._cells = finer, CHECK_CELLS
        return float(np.sqrt(total))

    def _halved(self, cells: int) -> list[Readings]:
        return self._simulated(cells, [each.forward for each in self._finest])

    def _changes(self, finer: Sequence[Readings], values: Sequence[Array]) -> list[Array]:
        """What a finer simulation changes, by run, shape (rows, outputs) each."""
        return [self._means(finer, i, z) - self._means(self._finest, i, z) for i, z in enumerate(values)]

    def refine(self, values: Sequence[Array]) -> None:
        """Take the grid's error out as it is at given values of the freed variables, slots by run.

        That of the finest steps is of second order, so that it is 4/3 of what half of each step changes. The
        cells stay: their number is a property of the model.
        """
        self._refined_at = tuple(values)
        self.__dict__.pop("leaping", None)
        for simulated in (self._readings, self._finest):
            for readings, z in zip(simulated, values, strict=True):
                readings.forward.refine(z[: len(self.inner)])
        changes = self._changes(self._halved(self._cells), values)
        self._beyond_finest = tuple(4 / 3 * change for change in changes)
        self._corrections = tuple(
            self.finest(i, z) - self._means(self._readings, i, z) for i, z in enumerate(values)
        )

    @cached_property
    def floors(self) -> Array:
        """Least noise of each channel in SI: the forward model is no more exact than this."""
        units = map(self.experiment.rig.unit, self.variables)
        read = zip(units, np.concatenate([data.readings for data in self.data]).T, strict=True)
        return np.array(
            [_FLOORS.get(u) or max(_SHARE * (np.nanmax(r) - np.nanmin(r)), _LEAST) for u, r in read]
        )

    def _means(self, readings: Sequence[Readings], run: int, z: Array) -> Array:
        return self._mean(run, readings[run](z, ())[0])

    def _mean(self, run: int, each: Array) -> Array:
        """Readings or derivatives as means over the blocks of rows that were averaged."""
        weight = self.data[run].weight
        if weight.shape[1] == 1:
            return each
        return np.einsum("bpo,bpo...->bo...", weight, each.reshape(*weight.shape[:2], *each.shape[1:]))

    def responses(self, run: int, z: Array, courses: Courses) -> Array:
        """Derivatives of a run's readings by the values of courses, shape (rows, outputs, values)."""
        return self._mean(run, self._readings[run].responses(z, courses))

    @cached_property
    def scattered(self) -> tuple[Array, ...]:
        """What the scatter of logged inputs does to each run's readings, shape (rows, outputs, columns).

        Columns are independent, 1 sigma each. The scatter is replaced by a broken line, whose values at the
        nodes are independent and have its power at the low frequencies, to which alone heat responds.
        """
        return tuple(self._scattered(i, run) for i, run in enumerate(self.experiment.runs))

    def switched(self, i: int, z: Array) -> Array:
        """What it does to a run's readings that a leap of its inputs came at some time between two rows.

        Shape (rows, outputs, columns); columns are independent, 1 sigma each. Some are of each leap, and some
        of all of them together, by up to the usual time between rows: a logger may write down what is, what
        was, or what will be.
        """
        run = self.experiment.runs[i]
        rows = leaps(input_table(self.experiment.rig, run, self.known(run)))
        parts = _PARTS + int(run.gaps[rows - 1].any())
        some = np.array_split(rows, max(1, -(-rows.size // _AT_ONCE)))
        table = self._mean(i, np.concatenate([self._finest[i].sooner(z, e, parts) for e in some], axis=2))
        table = table.reshape(*table.shape[:2], rows.size, parts)
        sooner = run.time[rows] - parts_before(run, rows, parts)[::-1]
        usual = np.median(np.diff(run.time)) * np.append(0.0, np.linspace(0.5, 1.0, parts))
        each = [table[:, :, k] @ root_of(_spread(ends, usual[-1])) for k, ends in enumerate(sooner.T)]
        alike, after = np.minimum(1, np.diff(usual)[:, None] / np.diff(sooner, axis=0)), _after(usual)
        together = np.einsum("torp,pr->top", table, alike) @ root_of(after.T @ after / len(after))
        return np.concatenate([*each, together], axis=2)

    @cached_property
    def leaping(self) -> tuple[Array, ...]:
        """The same of every run, at the values at which the grid's error was last taken out."""
        return tuple(self.switched(i, z) for i, z in enumerate(self._refined_at))

    def _scattered(self, i: int, run: Run) -> Array:
        if not run.scatter:
            return np.zeros((self.data[i].time.size, len(self.variables), 0))
        span = float(run.time[-1])
        count = int(np.clip(span / _SPACING, 2, _MOST_NODES))
        slots = [(self.slots.index(f"{OFFSET}:{name}"),) for name in run.scatter]
        courses = Courses(tuple(slots), np.linspace(0.0, span, count + 1))
        # White rows have the power of so many rows of equal length.
        rows = span**2 / float(np.sum(np.diff(run.time) ** 2))
        sizes = np.array([*run.scatter.values()]) * np.sqrt(count / rows)
        return self.responses(i, self.neutral[i], courses) * np.repeat(sizes, count + 1)

    def _ordinary(self) -> tuple[Array, Array]:
        """Bounds between which the inner slots are freed, the narrowest, shape (slots,) each."""
        count = len(self.inner)
        middle = self.neutral[0][:count]
        lower, upper = middle - 1.0, middle + 1.0
        narrowest = np.full(count, np.inf)
        for freed in self.numbers:
            for i in (i for i in freed.slots if i < count and freed.span < narrowest[i]):
                start = middle[i] if freed.added else 0.0
                narrowest[i], lower[i], upper[i] = freed.span, start + freed.lower, start + freed.upper
        return lower, upper

    @cached_property
    def _finest(self) -> list[Readings]:
        return self._simulated(FINAL.cells, [FINAL] * len(self.data))

    def _simulated(
        self, cells: int, grids: Sequence[Resolution | Simulation], derivatives: bool = False
    ) -> list[Readings]:
        """Readings of each run, simulated on the grid for that run."""
        outputs = outputs_behind(self.experiment.rig, self.variables)

        def simulation(run: Run, grid: Resolution | Simulation) -> Simulation:
            known, rig = self.known(run), self.experiment.rig
            if rig.in_loop:
                coarser = grid if isinstance(grid, Loop) else None
                bounds = self._ordinary() if derivatives else None
                return Loop(rig, self.inner, outputs, run, known, coarser, bounds)
            apart = frozenset(name for name in given_inputs(rig, run, known) if len(rig.fed_with(name)) > 1)
            compiled = equations(rig, cells, self.inner, outputs, derivatives, apart)
            assert isinstance(grid, Resolution | Forward)
            return Forward(compiled, run, known, grid)

        return [
            Readings(simulation(run, grid), self.variables, self.outer, self.data[i].within.ravel())
            for i, (run, grid) in enumerate(zip(self.experiment.runs, grids, strict=True))
        ]


def _spread(ends: Array, usual: float) -> Array:
    """Covariance of the parts that come after a leap at any time, shape (parts, parts).

    That all leaps come sooner alike, by half of the usual time between rows, is told apart from it. After a
    longer pause the leap comes sooner still: its mean is not known any better than the leap itself.
    """
    after = _after(ends)
    mean = after.mean(axis=0) * max(0.0, 1 - _PAUSED * usual / ends[-1])
    return np.asarray(np.atleast_2d(np.cov(after.T)) + np.outer(mean, mean))


def _after(ends: Array) -> Array:
    """How much of each part of the time between two rows comes after leaps at any time, shape (leaps, parts).

    The ends of the parts are told in s before the later row, rising from 0, shape (parts + 1,).
    """
    came = np.linspace(0, ends[-1], 1001)[:, None]
    return np.clip((came - ends[:-1]) / np.diff(ends), 0, 1)
