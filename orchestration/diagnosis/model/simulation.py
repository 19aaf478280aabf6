"""A measured run, simulated again and again: what the fits ask for, whatever computes it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER, PAD_TEMPERATURE
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.rig import SCALE, Rig
from warmlink.orchestration.diagnosis.model.integrator import Courses

PAD_OFF = 0


class NotSimulatedError(InputError):
    """A run that ended early, as it may with values of parameters far from their usual ones."""


@dataclass(frozen=True)
class Trajectory:
    """True outputs at times, shape (times, outputs), before any instrument reads them, and their slopes.

    `by_slot` are derivatives, shape (times, outputs, slots), or (times, outputs, 0) where none are requested.
    """

    values: Array
    slopes: Array
    by_slot: Array


class Simulation(ABC):
    """Simulates one run with other and other values of what may be freed.

    Parameters
    ----------
    rig : the system
    slots : what may be freed, by full name
    run : the measured run: its times and inputs
    known : value in SI by parameter or input, as far as it differs from the system's
    """

    def __init__(self, rig: Rig, slots: Sequence[str], run: Run, known: Mapping[str, float]) -> None:
        self.rig, self.slots = rig, tuple(slots)
        self._known, self._rows, self._table = known, run.time, input_table(rig, run, known)

    @property
    @abstractmethod
    def time(self) -> Array:
        """Points between steps in s, rising."""

    @abstractmethod
    def __call__(self, z: Array, times: Array) -> Trajectory:
        """Simulate with values of the slots in SI, shape (slots,); times in s within the run, rising."""

    @abstractmethod
    def responses(self, z: Array, times: Array, courses: Courses) -> Array:
        """Derivatives of the outputs by the courses' values at the nodes, shape (times, outputs, values)."""

    def linearise(self, z: Array) -> None:  # noqa: B027
        """Take derivatives that hold near some values of the slots alone anew."""

    def start_values(self) -> Array:
        """Values of the slots as the experiment has them, shape (slots,)."""
        held = {name: float(self.rig.variables[name].start or 0.0) for name in self.rig.parameters}
        held |= {**self._known, **dict(zip(self.rig.externals, self._table[:, 0].tolist(), strict=True))}
        return np.array([held.get(slot, float(slot.startswith(SCALE))) for slot in self.slots])

    def current(self, times: Array) -> Array:
        """Motor current in A as logged at times in s, shape (times,); 0 without a motor of ours."""
        rig = self.rig
        if rig.in_loop or "motor.current" not in rig.externals:
            return np.zeros(times.size)
        constant = self._known.get("motor.torque_constant", rig.variables["motor.torque_constant"].start)
        current, torque = (
            self._table[rig.externals.index(f"motor.{name}")] for name in ("current", "torque")
        )
        return np.asarray((current + torque / constant)[held_row(self._rows, times)])


def held_row(rows: Array, times: Array) -> NDArray[np.int64]:
    """Rows whose values hold at times in s, shape (times,)."""
    return np.clip(np.searchsorted(rows, times, side="right") - 1, 0, rows.size - 1)


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
