"""The growth that a compensator based on a model would have left in the measured runs.

Two compensators are compared, each based once on the machine as it stands and once on the extended model: the
model itself as a feed-forward, and the shipped observer, newly designed, which is fed with what the machine
feeds its controller, as it was logged: thermometers, speed, torque and ambient temperature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.extension import extended_values
from warmlink.orchestration.diagnosis.answer.growth import growth_of
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted
from warmlink.orchestration.diagnosis.model.equations import bound
from warmlink.orchestration.diagnosis.model.instruments import channel_of
from warmlink.orchestration.machine.machine import merged
from warmlink.orchestration.machine.plant import plant_of
from warmlink.orchestration.machine.rig import Rig

LAW = "observer"
READ_BY_LAW = ("base_temperature", "tip_temperature")
"""Thermometers that the shipped observer reads, as far as they were measured."""

AVERAGED = 120.0
"""s over which an error is averaged before its largest value is taken, against the camera's noise."""

_STEP = 10.0
"""s between two corrections, at least."""

_AFTER_PAD = 1800.0
"""s after which a pad no longer affects the observer."""


@dataclass(frozen=True)
class Compensated:
    """Largest error in m of the tool point over all runs, as the mean over a stretch, and its 95 % interval.

    The interval is that of the readings' scatter about the means of stretches.
    """

    largest: float
    low95: float
    high95: float


def feed_forward(problem: Problem, predicted: Predicted) -> Compensated | None:
    """Largest error when a model's growth is taken out; None if it fails in every row.

    Raises InputError if the growth was not measured.
    """
    growth = growth_of(problem)
    pairs = zip(problem.data, predicted.readings, strict=True)
    return _largest([(data.time, growth(data.readings - readings)) for data, readings in pairs])


def observer(problem: Problem, fit: Fit, truth: Fit) -> Compensated | None:
    """Largest error of the observer designed on a fitted model; None if it fails in every row.

    Readings of the problem's runs, held-out rows included, are corrected for faults of the instruments by
    `truth`, the best model known. The law does not know of a heating pad, and falls back while one is on:
    those stretches are left out.

    Raises InputError if the growth was not measured, or no observer can be designed for the machine.
    """
    rig, growth = problem.experiment.rig, growth_of(problem)
    values, faults = extended_values(problem, fit), extended_values(problem, truth)
    law = _Designed(problem, values)
    errors = []
    for run in problem.experiment.runs:
        if set(growth.variables) <= run.readings.keys():
            read = [_reading(rig, run, name, faults) for name in growth.variables]
            grown = np.asarray(sum(w * each for w, each in zip(growth.weights, read, strict=True)))
            errors.append((run.time, np.where(_padded(rig, run), np.nan, grown - law.corrections(run))))
    return _largest(errors)


def feed_forwards(
    problem: Problem, before: Predicted, after: Predicted
) -> tuple[Compensated, Compensated] | None:
    """The same of two models; None if one fails in every row."""
    first, then = feed_forward(problem, before), feed_forward(problem, after)
    return None if first is None or then is None else (first, then)


def observers(
    problem: Problem, before: Predicted, after: Predicted
) -> tuple[Compensated, Compensated] | None:
    """The same of observers designed on two models, the second the best known; None if one fails.

    Raises InputError, as `observer` does, and if the second model has an equation of heat.
    """
    null, chosen = before.fit, after.fit
    if after.model.experiment is not problem.experiment:
        raise InputError("an observer is designed for a machine's parameters, and knows no equation of heat")
    first = observer(problem, null, chosen)
    then = first if chosen is null else observer(problem, chosen, chosen)
    return None if first is None or then is None else (first, then)


def _padded(rig: Rig, run: Run) -> NDArray[np.bool_]:
    """Rows with the pad on, or on not long ago."""
    heated = np.zeros(run.time.size, dtype=bool)
    for name in (f"{motor}.pad_temperature" for motor in rig.called("motor")):
        heated |= np.isfinite(run.inputs.get(name, np.full(run.time.size, np.nan)))
    on = np.append(-np.inf, run.time[heated])
    return run.time - on[np.searchsorted(on, run.time, side="right") - 1] < _AFTER_PAD


def _largest(errors: Sequence[tuple[Array, Array]]) -> Compensated | None:
    """Largest mean over a stretch of errors at times, spikes left out."""
    stretches: list[Array] = []
    for time, error in errors:
        good = np.isfinite(error)
        _, starts = np.unique(np.floor(time[good] / AVERAGED), return_index=True)
        for inside in np.split(error[good], starts[1:]) if starts.size else ():
            away = np.abs(inside - np.median(inside))
            stretches.append(inside[away <= 8 * 1.4826 * float(np.median(away)) + 1e-7])
    if not stretches:
        return None
    scatter = np.concatenate([s - s.mean() for s in stretches])
    freedom = max(scatter.size - len(stretches), 1)
    worst = max(stretches, key=lambda s: abs(float(s.mean())))
    largest = abs(float(worst.mean()))
    spread = 1.96 * float(np.sqrt(scatter @ scatter / freedom / worst.size))
    return Compensated(largest, max(largest - spread, 0.0), largest + spread)


class _Designed:
    """The observer for a machine with other parameters than the nominal, fed with what was logged.

    Raises InputError if none can be designed.
    """

    def __init__(self, problem: Problem, values: Mapping[str, float]) -> None:
        from warmlink.controllers.design.gains import design_controller

        self._rig, self._values = problem.experiment.rig, values
        machine = self._rig.machine
        if len(machine.controllers) != 1:
            raise InputError(
                f"{machine.name}: an observer is designed for one controller, and it has "
                f"{len(machine.controllers) or 'no place for any'}; name one as controller under [roles]"
            )
        (self._controller,) = machine.controllers
        owners = {name: self._rig.part_of(name) for name in values if name in self._rig.parameters}
        own = ({part: {name[len(part) + 1 :]: values[name]}} for name, part in owners.items())
        given = merged(machine.nominal, *own)
        plant = plant_of(machine, self._rig.components, given)
        measured = {self._rig.on_link(name) or name: name for name in problem.variables}
        read = {name: self._rig.on_link(plant.read[name]) or plant.read[name] for name in plant.read}
        self._read = {name: measured[read[name]] for name in READ_BY_LAW if read.get(name) in measured}
        spacing = min(float(np.median(np.diff(run.time))) for run in problem.experiment.runs)
        found = design_controller(LAW, list(self._read), sample_time=max(spacing, _STEP), plant=plant)
        self._given = by_scalar(found.parameters)

    def corrections(self, run: Run) -> Array:
        """Correction in m at each row of a run."""
        from warmlink.controllers.observer.component import COMPONENT
        from warmlink.fmus.component import limits

        step = self._given["sample_time"]
        count = int(np.ceil(run.time[-1] / step))
        rows = run.row_at(step * np.arange(count + 1))
        inputs = np.repeat(np.array([[float(v.start or 0.0)] for v in COMPONENT.inputs]), count + 1, axis=1)
        for name, signal in self._signals(run).items():
            inputs[COMPONENT.u.index[name]] = signal[rows]
        settled = np.asarray(COMPONENT.settled(limits.checked(COMPONENT, LAW, self._given)[0]))
        begin, update = _compiled_law()
        x, now = np.array(begin(inputs[:, 0], settled)).ravel(), inputs[:, 0].copy()
        fed, after = [x, now, settled, np.array([step])], x.copy()
        _buffer, evaluate = bound(update, fed, [after])
        states = [x.copy()]
        for each in inputs.T[1:]:
            now[:] = each
            evaluate()
            x[:] = after
            states.append(x.copy())
        corrections = np.array(states)[:, COMPONENT.x.index["correction"]]
        return np.interp(run.time, step * np.arange(count + 1), corrections)

    def _signals(self, run: Run) -> dict[str, Array]:
        """Inputs of the observer by name, corrected for the model's faults of sensors and surroundings."""
        signals: dict[str, Array] = {}
        for name in SENSED:
            signals[name] = np.full(run.time.size, np.nan)
            if (variable := self._read.get(name)) in run.readings:
                signals[name] = _reading(self._rig, run, str(variable), self._values)
        for name in ("speed", "torque", "ambient_temperature"):
            if end := self._rig.input_behind(f"{self._controller}.{name}"):
                start = np.full(run.time.size, float(self._rig.variables[end].start or 0.0))
                signals[name] = np.abs(run.inputs.get(end, start))
        if "ambient_temperature" in signals:
            (motor, *_) = self._rig.called("motor")
            offset, drift = (self._values.get(f"{motor}.ambient_{name}", 0.0) for name in ("offset", "drift"))
            signals["ambient_temperature"] += offset + drift * run.time
        return signals


def _reading(rig: Rig, run: Run, variable: str, faults: Mapping[str, float]) -> Array:
    """Readings of an output, corrected for the known faults of its instrument except the lag."""
    fault = channel_of(rig, variable).faults(faults)
    values = (run.readings[variable] - fault["offset"] - fault["drift_rate"] * run.time) / fault["scale"]
    stem = fault["stem_conduction"]
    ambient = run.ambient
    return values if ambient is None or stem == 0 else (values - stem * ambient) / (1 - stem)


@cache
def _compiled_law() -> tuple[Any, Any]:
    """First states by inputs and settled parameters; the next by states, inputs, these and the step."""
    import casadi as ca

    from warmlink.controllers.observer.component import COMPONENT

    sizes = {"x": COMPONENT.x.size, "u": COMPONENT.u.size, "d": COMPONENT.d.size, "step": 1}
    x, u, d, step = (ca.SX.sym(name, size) for name, size in sizes.items())
    begin = ca.Function("begin", [u, d], [COMPONENT.states_at_start(u, d)])
    after = [COMPONENT.updated(x, u, d, 0.0, step)]
    return begin, ca.Function("update", [x, u, d, step], after, {"cse": True})
