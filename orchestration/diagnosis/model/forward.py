"""Simulation of a measured run with the derivatives by all freed variables, in one pass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER, PAD_TEMPERATURE
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.rig import SCALE, Rig
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.integrator import Courses, Integrator, Steps, each_slot
from warmlink.orchestration.diagnosis.model.steps import ORDINARY, Levels, Resolution, controlled, hermite

PAD_OFF = 0

_WILD = 0.1
"""K by which the slopes at the ends of a step may disagree with what changes over it."""


class NotSimulatedError(InputError):
    """A run that ended early, as it may with values of parameters far from their usual ones."""


@dataclass(frozen=True)
class Trajectory:
    """True outputs at times, before any instrument reads them.

    Attributes
    ----------
    values : shape (times, outputs)
    slopes : time derivatives of the values
    by_slot : derivatives, shape (times, outputs, slots), or (times, outputs, 0) where they were not requested
    """

    values: Array
    slopes: Array
    by_slot: Array


class Forward:
    """Simulates one run, again and again, with other values of the freed variables.

    Parameters
    ----------
    equations : the compiled rig
    run : the measured run: its times and inputs
    known : value by parameter or input, as far as it differs from the nominal
    grid : how finely, or another simulation of the run: each of its steps is halved

    Attributes
    ----------
    rig, slots : as of the equations
    """

    def __init__(
        self,
        equations: Equations,
        run: Run,
        known: Mapping[str, float],
        grid: Resolution | Forward,
    ) -> None:
        self.equations, self.slots = equations, equations.slots
        self.rig = rig = equations.rig
        self._p = equations.parameter_values.copy()
        index = {name: i for i, name in enumerate(rig.parameters)}
        for name, value in known.items():
            if name in index:
                self._p[index[name]] = value
        self._known, self._w, self._rows = known, input_table(rig, run, known), run.time
        # Instruments are fitted to the same course.
        self._course = lru_cache(maxsize=1)(lambda z: self._integrate(np.frombuffer(z)))
        discrete = np.array([rig.variables[name].is_discrete for name in rig.externals], dtype=bool)
        self._levels, self._grid = Levels(run.time, self._w, discrete), grid

    @cached_property
    def steps(self) -> Steps:
        """What the steps are in time; found when they are first needed."""
        if isinstance(self._grid, Forward):
            return self._levels.halved(self._grid.steps.time)
        z = self.start_values()
        begun, _ = self.equations.begin(z, self._p, self._w[:, 0])
        return controlled(Integrator(self.equations, z, self._p), self._levels, begun, self._grid)

    @property
    def time(self) -> Array:
        """Points between steps in s."""
        return self.steps.time

    def start_values(self) -> Array:
        """Values of the freed variables as the experiment has them, shape (slots,)."""
        return start_values(self.rig, self.slots, self._known, self._w)

    def linearise(self, z: Array) -> None:
        """Nothing to do: the derivatives hold everywhere."""

    def current(self, times: Array) -> Array:
        """Motor current in A as logged at times in s, shape (times,); 0 where the system has no motor."""
        rig = self.equations.rig
        if "motor.current" not in rig.externals:
            return np.zeros(times.size)
        constant = self._p[rig.parameters.index("motor.torque_constant")]
        current, torque = (self._w[rig.externals.index(f"motor.{name}")] for name in ("current", "torque"))
        return np.asarray((current + torque / constant)[held_row(self._rows, times)])

    def __call__(self, z: Array, times: Array) -> Trajectory:
        """Simulate.

        Parameters
        ----------
        z : values of the freed variables in SI, shape (slots,)
        times : s within the run, rising, shape (times,)
        """
        values, slopes, by_slot, direct = self._interpolated(z, *self._course(z.tobytes()), times)
        return Trajectory(values, slopes, by_slot + direct)

    def responses(self, z: Array, times: Array, courses: Courses) -> Array:
        """Derivatives of the outputs by the courses' values at the nodes, shape (times, outputs, values).

        The outputs follow the courses through the states alone.
        """
        return self._interpolated(z, *self._integrate(z, courses), times)[2]

    def _integrate(self, z: Array, courses: Courses | None = None) -> tuple[Array, Array, Array]:
        """States and sensitivities between steps, and their slopes at both ends of each step.

        The sensitivities are those by the slots, or else by courses, which begin at rest.
        """
        x, begun = self.equations.begin(z, self._p, self._w[:, 0])
        if courses is None:
            courses = each_slot(self.equations.columns)
        else:
            begun = np.zeros((x.size, courses.size))
        step = Integrator(self.equations, z, self._p, courses)
        states, left, right, _ = step(self.steps, np.column_stack([x, begun]))
        if not np.isfinite(states[:, :, 0]).all():
            raise NotSimulatedError("with these values of the parameters the simulation is not finite")
        _straighten(self.steps.time, states, left, right)
        return states, left, right

    def _interpolated(
        self, z: Array, states: Array, left: Array, right: Array, times: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Outputs at times, their slopes, and derivatives through the states and directly by slot.

        Cubic Hermite in time, as the states' slopes are known at both ends.
        """
        time = self.steps.time
        columns = [shares[0][0] for shares in self.steps.shares]
        columns.append(columns[-1])
        y, by_state, direct = self.equations.observe(
            states[:, :, 0].T, z, self._p, self.steps.inputs[columns].T, time
        )
        # (points, outputs, 1 + slots): value and sensitivity through the states
        through = by_state @ states
        through[:, :, 0] = y
        known = np.concatenate([through, by_state[:-1] @ left, by_state[1:] @ right])
        k = np.clip(np.searchsorted(time, times, side="right") - 1, 0, len(self.steps.shares) - 1)
        length = time[k + 1] - time[k]
        s = np.clip((times - time[k]) / length, 0.0, 1.0)
        ends = np.stack([k, k + 1, time.size + k, time.size + len(self.steps.shares) + k], axis=1)
        inside = 6 * s * (1 - s) / length
        rates = -inside, inside, (1 - s) * (1 - 3 * s), s * (3 * s - 2)
        value = _weighted(hermite(s, length), ends, known)
        slope = _weighted(rates, ends, known[:, :, 0])
        return value[:, :, 0], slope, value[:, :, 1:], _weighted((1 - s, s), ends[:, :2], direct)


def _straighten(time: Array, states: Array, left: Array, right: Array) -> None:
    """Replace slopes that say nothing of their step by that of the line through its ends.

    A cell of hardly any mass at the end of a link settles within a second. Beside its neighbours it is right
    at both ends of a step of a minute, but its slopes there are the last trace of its settling: a cubic with
    them would leave the course by many K.
    """
    length = np.diff(time)[:, None]
    change = np.diff(states[:, :, 0], axis=0)
    bend = np.abs(change - length / 2 * (left[:, :, 0] + right[:, :, 0]))
    wild = np.nonzero(bend > _WILD * np.maximum(1.0, np.abs(states[1:, :, 0]) / ORDINARY))
    if wild[0].size:
        line = (states[1:][wild] - states[:-1][wild]) / length[wild[0]]
        left[wild] = right[wild] = line


def _weighted(weights: Sequence[Array], places: NDArray[np.int64], table: Array) -> Array:
    """Sums of a table's rows at places, shape (sums, terms), with a weight for each term, shape (sums,)."""
    from scipy.sparse import csr_array

    sums, terms = places.shape
    begins = np.arange(0, sums * terms + 1, terms)
    matrix = csr_array((np.stack(weights, axis=1).ravel(), places.ravel(), begins), shape=(sums, len(table)))
    return np.asarray(matrix @ table.reshape(len(table), -1)).reshape(sums, *table.shape[1:])


def held_row(rows: Array, times: Array) -> NDArray[np.int64]:
    """Rows whose values hold at times in s, shape (times,)."""
    return np.clip(np.searchsorted(rows, times, side="right") - 1, 0, rows.size - 1)


def start_values(rig: Rig, slots: Sequence[str], known: Mapping[str, float], table: Array) -> Array:
    """Values of what may be freed as an experiment has them, shape (slots,); see `input_table`."""
    held = {name: float(rig.variables[name].start or 0.0) for name in rig.parameters} | dict(known)
    held |= dict(zip(rig.externals, table[:, 0].tolist(), strict=True))
    return np.array([held.get(slot, float(slot.startswith(SCALE))) for slot in slots])


def input_table(rig: Rig, run: Run, known: Mapping[str, float]) -> Array:
    """Inputs that nothing in the rig feeds, held from row to row, shape (externals, rows)."""
    begun = np.array([float(rig.variables[name].start or 0.0) for name in rig.externals])
    table = np.repeat(begun[:, None], run.time.size, axis=1)
    index = {name: i for i, name in enumerate(rig.externals)}
    for name, value in known.items():
        if name in index:
            table[index[name]] = value
    given_here = {*run.inputs, *(name for name in known if name in index)}
    for name, signal in [*run.inputs.items(), *_covariates(rig.externals, run)]:
        for target in rig.fed_with(name):
            if target == name or target not in given_here:
                table[index[target]] = signal
    for motor in rig.called("motor"):
        if f"{motor}.pad_temperature" in index:
            _switch_pad(motor, table, index, given_here)
    return table


def _switch_pad(motor: str, table: Array, index: Mapping[str, int], given_here: set[str]) -> None:
    """Set the pad's mode from the given inputs of the pad, unless the mode itself is given."""
    pad, mode = f"{motor}.pad_temperature", f"{motor}.pad_mode"
    temperature = table[index[pad]]
    held = np.isfinite(temperature)
    if mode not in given_here and mode in index:
        by_power = PAD_POWER if f"{motor}.pad_power" in given_here else PAD_OFF
        table[index[mode]] = np.where(held & (pad in given_here), PAD_TEMPERATURE, by_power)
    table[index[pad]] = np.where(held, temperature, 0.0)  # acts on nothing while the pad is off


def _covariates(externals: Sequence[str], run: Run) -> list[tuple[str, Array]]:
    """Signal by full input name for covariates, which are named without their instance."""
    return [
        (name, signal)
        for covariate, signal in run.covariates.items()
        for name in externals
        if name == covariate or name.rpartition(".")[2] == covariate
    ]
