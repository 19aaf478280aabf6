"""What may begin to be wrong while a machine is at work: causes of the catalogue, each with its verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.offers import freed_by
from warmlink.orchestration.diagnosis.model.equations import Equations, equations
from warmlink.orchestration.diagnosis.model.instruments import logger_of
from warmlink.orchestration.diagnosis.model.simulation import start_values
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.watch.ticks import TICK

CELLS = 12
"""Finite volumes of a link in the filter: coarse, as it is calibrated and its noise covers the rest."""

MODEL, THERMOMETER, CLOCK, LAW = "model", "thermometer", "clock", "law"
"""Verdicts."""

_SPAN = 6.0
"""Standard deviations, before anything is seen, between a cause's bounds."""

_OFFSET = {"K": 0.5, "m": 5e-6}
"""The same of a reading's offset, by its unit."""


@dataclass(frozen=True)
class Hypothesis:
    """One thing that may be wrong.

    Attributes
    ----------
    name : of the cause, with the channel after a colon
    verdict : which of the verdicts it belongs to
    slots : indices of the variables of the model that take the value; empty for an instrument or a clock
    reading : weight of each reading that is off by the value, shape (outputs,)
    late : weight of each reading that comes late by the value in s, shape (outputs,)
    lower, upper, start : bounds and the value that changes nothing, in SI
    variable, unit : the first that it frees, and the unit of the value
    wears : whether it may begin at work, so that it is watched for
    cause : as the catalogue has it
    """

    name: str
    verdict: str
    slots: tuple[int, ...]
    reading: Array
    late: Array
    lower: float
    upper: float
    start: float
    variable: str
    unit: str
    wears: bool
    cause: Cause

    @property
    def span(self) -> float:
        """One standard deviation of the value before anything is seen."""
        return (self.upper - self.lower) / _SPAN


@dataclass(frozen=True)
class WatchedMachine:
    """A machine with what is measured of it, as equations with a slot for everything that may be wrong.

    Attributes
    ----------
    rig : the machine
    known : values in SI by variable that differ from the nominal ones
    outputs : what is measured, in order
    names : column by variable
    equations : its rates and outputs, with derivatives by state and by slot
    slots : values of the slots, as the model has them, shape (slots,)
    wander : the slots that each signal nobody logged adds to, a matrix of 0 and 1, shape (slots, signals)
    signals : names of those signals, `room` and `heat`
    hypotheses : everything that may be wrong
    inputs : that are logged
    tick : s of the log in one tick
    """

    rig: Rig
    known: Mapping[str, float]
    outputs: tuple[str, ...]
    names: Mapping[str, str]
    equations: Equations
    slots: Array
    wander: Array
    signals: tuple[str, ...]
    hypotheses: tuple[Hypothesis, ...]
    inputs: tuple[str, ...]
    tick: float

    @property
    def groups(self) -> Array:
        """The slots that each hypothesis frees, a matrix of 0 and 1, shape (slots, hypotheses)."""
        found = np.zeros((self.slots.size, len(self.hypotheses)))
        for i, each in enumerate(self.hypotheses):
            found[list(each.slots), i] = 1.0
        return found

    @property
    def watched(self) -> NDArray[np.bool_]:
        """Whether each hypothesis may begin at work, shape (hypotheses,)."""
        return np.array([each.wears for each in self.hypotheses])


def watched(
    rig: Rig,
    known: Mapping[str, float],
    inputs: Sequence[str],
    outputs: Sequence[str],
    names: Mapping[str, str],
    tick: float = TICK,
) -> WatchedMachine:
    """A machine as it is watched.

    Parameters
    ----------
    rig : the machine
    known : values in SI by variable that differ from the nominal ones
    inputs, outputs : that are logged
    names : column by variable
    tick : s of the log in one tick

    Raises
    ------
    InputError
        The machine has parts whose equations are not known.
    """
    if rig.in_loop:
        raise InputError(
            f"{rig.name}: holds FMUs whose equations are not known, and a filter needs them; "
            "watch a machine of components that join"
        )
    still = {name: np.zeros(2) for name in inputs}
    run = Run("watch", np.array([0.0, 1.0]), still, {name: np.zeros(2) for name in outputs})
    experiment = Experiment(rig.name, rig, (run,), (), known)
    offered = [
        (cause, name, freed)
        for cause in experiment.catalogue
        if cause.at_work or cause.usual
        for name, freed in freed_by(cause, experiment, {each: names[each] for each in outputs})
    ]
    inner = dict.fromkeys(v for cause, _, freed in offered if cause.kind in ("plant", "input") for v in freed)
    inner |= dict.fromkeys(slot for slots in rig.wandering.values() for slot in slots)
    slots = tuple(inner)
    compiled = equations(rig, CELLS, slots, tuple(outputs), True, frozenset(inputs))
    compiled.compile()
    begun = np.array([[float(rig.variables[name].start or 0.0)] for name in rig.externals])
    values = start_values(rig, slots, known, begun)
    wander = np.array([[float(s in each) for each in rig.wandering.values()] for s in slots])
    maker = _Maker(rig, tuple(outputs), names, slots, values)
    found = tuple(h for each in offered if (h := maker.hypothesis(*each)) is not None)
    return WatchedMachine(
        rig,
        known,
        tuple(outputs),
        names,
        compiled,
        values,
        wander.reshape(len(slots), -1),
        tuple(rig.wandering),
        found,
        tuple(inputs),
        tick,
    )


@dataclass(frozen=True)
class _Maker:
    """Makes hypotheses of what the catalogue offers."""

    rig: Rig
    outputs: tuple[str, ...]
    names: Mapping[str, str]
    slots: tuple[str, ...]
    values: Array

    def hypothesis(self, cause: Cause, name: str, freed: tuple[str, ...]) -> Hypothesis | None:
        nothing, channel = np.zeros(len(self.outputs)), name.partition(":")[2]
        if cause.kind == "record":
            mine = [not channel or logger_of(self.rig, each) == channel for each in self.outputs]
            return self._made(cause, name, CLOCK, (), nothing, np.array(mine, dtype=float), freed)
        if cause.kind in ("plant", "input"):
            at = tuple(self.slots.index(each) for each in freed)
            return self._made(cause, name, MODEL, at, nothing, nothing, freed)
        if cause.name != "sensor_offset":
            return None
        weight = np.array([float(self.names[each] == channel) for each in self.outputs])
        return self._made(cause, name, THERMOMETER, (), weight, nothing, freed)

    def _made(
        self,
        cause: Cause,
        name: str,
        verdict: str,
        slots: tuple[int, ...],
        reading: Array,
        late: Array,
        freed: tuple[str, ...],
    ) -> Hypothesis | None:
        nominal = float(self.values[slots[0]]) if slots else 0.0
        size = nominal if cause.relative else 1.0
        lower, upper = cause.lower * size, cause.upper * size
        unit = self.rig.unit(freed[0]) if freed[0] in self.rig.variables else cause.shown_unit
        if reading.any():
            unit = self.rig.unit(self.outputs[int(np.argmax(reading))])
            upper = _OFFSET.get(unit, 0.5) * _SPAN / 2
            lower = -upper
        if not lower < upper:
            return None  # a share of nothing, as of a joint that conducts nothing
        start = nominal if cause.neutral is None or slots else 0.0
        place = freed[0], unit, cause.at_work, cause
        return Hypothesis(name, verdict, slots, reading, late, lower, upper, start, *place)
