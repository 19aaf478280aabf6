"""The extended model: its values and files, and the growth that a compensator based on it would have left.

Two compensators are compared in the measured runs, each based once on the system as it stands and once on the
extended model: the model itself as a feed-forward, and the shipped observer, newly designed, which is fed
with the logged thermometers, speed, torque and ambient temperature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import Values, by_scalar
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.catalogue import components, controller
from warmlink.orchestration.diagnosis.answer.prediction import Predicted
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.data.own import extended, shipped_system, with_paths
from warmlink.orchestration.diagnosis.data.rig import ELONGATION, Rig
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder
from warmlink.orchestration.diagnosis.ladder.wired import with_remainder
from warmlink.orchestration.diagnosis.model.equations import bound
from warmlink.orchestration.diagnosis.model.instruments import channel_of

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

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


def extended_values(problem: Problem, fit: Fit) -> dict[str, float]:
    """Values in SI, by full variable name, of everything that differs from the nominal system.

    Where runs differ, the values are those of the first fitted run. What belongs to the log and its clock is
    no part of a model.
    """
    run = problem.fitted_runs[0]
    values = problem.values(run, fit.freed, fit.theta)
    known = dict(problem.known(problem.experiment.runs[run]))
    for freed in fit.freed:
        if run in freed.runs:
            known |= {problem.slots[i]: float(values[i]) for i in freed.slots}
    rig = problem.experiment.rig
    ours = set(rig.variables)
    for instance, kind in rig.blueprint.components.items():
        declared = components().get(kind)
        ours |= {f"{instance}.{scalar.name}" for scalar in declared.scalars()} if declared else set()
    return {name: float(v) for name, v in known.items() if name in ours and np.isfinite(v)}


def kinds_needed(diagnosed: Rig) -> list[str]:
    """Names of the components whose FMUs the extended model is written with; none for an SSP of one's own."""
    none = controller("none").name
    return [] if diagnosed.own else sorted(set(diagnosed.blueprint.components_with(none).values()))


def write_ssp_of(
    rig: Rig, values: Mapping[str, float], path: Path, store: FmuStore, learnt: Remainder | None = None
) -> None:
    """Write the system with the extended values bound, and the heat paths and remainder found wired in."""
    from warmlink.orchestration.system.write import write_ssp

    own = rig.own or with_paths(shipped_system(rig, store), {})
    system = extended(own, values)
    write_ssp(system if learnt is None else with_remainder(system, learnt), path)


def feed_forward(problem: Problem, predicted: Predicted) -> Compensated | None:
    """Largest error when a model's elongation is taken out; None where no elongation was measured."""
    if ELONGATION not in problem.variables:
        return None
    channel = problem.variables.index(ELONGATION)
    pairs = zip(problem.data, predicted.readings, strict=True)
    return _largest([(data.time, (data.readings - readings)[:, channel]) for data, readings in pairs])


def observer(problem: Problem, fit: Fit, truth: Fit) -> Compensated | None:
    """Largest error of the observer designed on a fitted model.

    None where no elongation was measured, and where no observer can be designed for the model. Readings of
    the problem's runs, held-out rows included, are corrected for faults of the instruments by `truth`, the
    best model known. The law does not know of a heating pad, and falls back while one is on: those
    stretches are left out.
    """
    rig = problem.experiment.rig
    if not rig.is_cell or ELONGATION not in problem.variables:
        return None
    values, faults = extended_values(problem, fit), extended_values(problem, truth)
    errors = []
    try:
        law = _designed(problem, values)
        for run in problem.experiment.runs:
            if ELONGATION in run.readings:
                error = _reading(rig, run, ELONGATION, faults) - _corrections(law, rig, run, values)
                errors.append((run.time, np.where(_padded(run), np.nan, error)))
    except InputError:
        return None
    return _largest(errors)


def _padded(run: Run) -> NDArray[np.bool_]:
    """Rows with the pad on, or on not long ago."""
    pad = run.inputs.get("motor.pad_temperature", np.full(run.time.size, np.nan))
    on = np.append(-np.inf, run.time[np.isfinite(pad)])
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


def _designed(problem: Problem, values: Mapping[str, float]) -> Values:
    """Parameters of the observer for a cell with other parameters than the nominal."""
    from warmlink.controllers.design.gains import design_controller
    from warmlink.controllers.design.plant import cell_plant

    def of(instance: str) -> dict[str, float]:
        names = problem.experiment.rig.parameters
        return {n.partition(".")[2]: v for n, v in values.items() if n in names and n.startswith(instance)}

    spacing = min(float(np.median(np.diff(run.time))) for run in problem.experiment.runs)
    return design_controller(
        LAW,
        [name for name in READ_BY_LAW if problem.experiment.rig.columns[name] in problem.variables],
        sample_time=max(spacing, _STEP),
        plant=cell_plant(of("motor."), of("link.")),
    ).parameters


def _reading(rig: Rig, run: Run, variable: str, faults: Mapping[str, float]) -> Array:
    """Readings of an output, corrected for the known faults of its instrument except the lag."""
    fault = channel_of(rig, variable).faults(faults)
    values = (run.readings[variable] - fault["offset"] - fault["drift_rate"] * run.time) / fault["scale"]
    stem = fault["stem_conduction"]
    ambient = run.inputs.get("motor.ambient_temperature")
    return values if ambient is None or stem == 0 else (values - stem * ambient) / (1 - stem)


def _corrections(parameters: Values, rig: Rig, run: Run, values: Mapping[str, float]) -> Array:
    """Correction in m at each row of a run."""
    from warmlink.controllers.observer.component import COMPONENT
    from warmlink.fmus.component import limits

    given = by_scalar(parameters)
    step = given["sample_time"]
    count = int(np.ceil(run.time[-1] / step))
    rows = run.row_at(step * np.arange(count + 1))
    inputs = np.repeat(np.array([[float(v.start or 0.0)] for v in COMPONENT.inputs]), count + 1, axis=1)
    for name, signal in _signals(rig, run, values).items():
        inputs[COMPONENT.u.index[name]] = signal[rows]
    settled = np.asarray(COMPONENT.settled(limits.checked(COMPONENT, LAW, given)[0]))
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


def _signals(rig: Rig, run: Run, values: Mapping[str, float]) -> dict[str, Array]:
    """Inputs of the observer by name, corrected for the model's faults of sensors and surroundings."""
    signals: dict[str, Array] = {}
    for name in SENSED:
        signals[name] = np.full(run.time.size, np.nan)
        if name in READ_BY_LAW and rig.columns[name] in run.readings:
            signals[name] = _reading(rig, run, rig.columns[name], values)
    for name in ("speed", "torque", "ambient_temperature"):
        start = np.full(run.time.size, float(rig.variables[f"motor.{name}"].start or 0.0))
        signals[name] = np.abs(run.inputs.get(f"motor.{name}", start))
    offset, drift = (values.get(f"motor.ambient_{name}", 0.0) for name in ("offset", "drift"))
    signals["ambient_temperature"] += offset + drift * run.time
    return signals
