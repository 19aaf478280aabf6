"""The regression law learnt from measured logs, with what the logs say of thermometers and of themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.controllers.design.training import TrainingRun, training_run
from warmlink.controllers.interface import SENSED
from warmlink.controllers.learning.learnt import LearntMap, learn
from warmlink.controllers.learning.observers import taught
from warmlink.controllers.learning.worth import correlations, learning_curve, worth
from warmlink.controllers.start_values import Values
from warmlink.fmus.arguments import argument
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.console import Answer
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.files import with_hash
from warmlink.orchestration.replay.logs import MeasuredLog, read_logs, sources_in
from warmlink.orchestration.scenarios.law_values import start_values_of, write_law_values
from warmlink.orchestration.written.quantities import positive

if TYPE_CHECKING:
    from warmlink.controllers.design.plant import Plant
    from warmlink.orchestration.replay.logs import Logs


LEARNS = ("regression", "observer", "observer_drift")
"""Laws that learn from a log."""

CELSIUS = 273.15

_NOTABLE = 0.3
"""Correlation from which on it is said of a signal."""

_ENOUGH = 1.1
"""Error, by that of the longest log, from which on a longer one hardly gains."""


@dataclass(frozen=True, repr=False)
class LearntLaw(Answer):
    """A law learnt from logs.

    Attributes
    ----------
    law : name of the controller
    learnt : what the logs taught
    logs : what it was learnt from
    sample_time : in s
    plant : a model of the machine that helped; None if there is none
    camera_std : noise of the camera in m; None for that of the DriftCamera
    source : the logs with the hashes of their files, and the model that helped
    """

    law: str
    learnt: LearntMap
    logs: tuple[MeasuredLog, ...]
    sample_time: float
    plant: Plant | None = None
    camera_std: float | None = None
    source: str = ""

    @cached_property
    def values(self) -> Values:
        """Parameters of the law's component, vectors as lists."""
        if self.law == "regression":
            return {**self.learnt.values, "sample_time": self.sample_time}
        return taught(self.law, self.learnt, self.sample_time, self.plant, self.camera_std)

    @property
    def parameters(self) -> dict[str, float]:
        """Start values for `run` and `compare`, in SI units."""
        return start_values_of(self.values)

    @cached_property
    def coefficients_um(self) -> dict[str, float]:
        """Growth in um per kelvin of each thermometer that the law uses."""
        of = zip(SENSED, self.learnt.coefficients.tolist(), strict=True)
        return {_short(name): 1e6 * value for name, value in of if value > 0}

    @property
    def intercept_um(self) -> float:
        """Growth in um with every thermometer at 0 degC."""
        rise = ROOM_TEMPERATURE - CELSIUS
        return 1e6 * self.learnt.intercept - rise * sum(self.coefficients_um.values())

    @property
    def formula(self) -> str:
        """The law in um by temperatures in degC, as it can be typed into a machine's control."""
        terms = (f" + {value:.4g} * T_{name}" for name, value in self.coefficients_um.items())
        return f"correction = {self.intercept_um:.5g}{''.join(terms)}"

    @cached_property
    def held_out_um(self) -> float:
        """Rms error in um of what was held out."""
        return 1e6 * self.learnt.held.rms

    @cached_property
    def held_out_worst_um(self) -> float:
        """Largest error in um of what was held out."""
        return 1e6 * float(np.abs(self.learnt.held.error).max())

    @cached_property
    def thermometers_um(self) -> dict[str, float]:
        """Rms error in um of what was held out by thermometers, as `base, tip`, the best first."""
        measured = np.isfinite(self.learnt.examples.temperature).all(axis=0)
        every = worth(self.learnt.examples, np.flatnonzero(measured).tolist(), self.learnt.model)
        found = {", ".join(_short(SENSED[i]) for i in used): 1e6 * rms for used, rms in every.items()}
        return dict(sorted(found.items(), key=lambda each: each[1]))

    @cached_property
    def worth_um(self) -> dict[str, float]:
        """By how much in um the rms error grows if a thermometer that the law uses is left out."""
        found = {}
        for name in self.coefficients_um if len(self.coefficients_um) > 1 else ():
            rest = ", ".join(each for each in self.coefficients_um if each != name)
            if rest in self.thermometers_um:
                found[name] = (
                    self.thermometers_um[rest] - self.thermometers_um[", ".join(self.coefficients_um)]
                )
        return found

    @cached_property
    def curve_um(self) -> dict[float, float]:
        """Rms error in um of the last third of the logs, by minutes of log that were learnt from."""
        return {minutes: 1e6 * rms for minutes, rms in learning_curve(self.learnt).items()}

    @property
    def enough_min(self) -> float | None:
        """Minutes of log from which on more hardly gains; None if the logs are too short to tell."""
        if len(self.curve_um) < 2:
            return None
        best = min(self.curve_um.values())
        return next(minutes for minutes, rms in self.curve_um.items() if rms <= _ENOUGH * best)

    @cached_property
    def correlates(self) -> dict[str, float]:
        """Correlation of what the law leaves with signals of the log, the largest first."""
        return correlations(self.learnt, [each.learnt_from for each in self.logs])

    def write(self, path: str | Path) -> None:
        """Write the parameter set (SSV) of the law's FMU; raises InputError where that cannot be done."""
        title = f"{self.law}, learnt from {', '.join(each.name for each in self.logs)}"
        write_law_values(self.law, self.values, path, title, self.source)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "law": self.law,
            "logs": [each.name for each in self.logs],
            "formula": self.formula,
            "coefficients_um_per_K": self.coefficients_um,
            "intercept_um": self.intercept_um,
            "held_out_rms_um": self.held_out_um,
            "held_out_worst_um": self.held_out_worst_um,
            "thermometers_rms_um": self.thermometers_um,
            "left_out_costs_um": self.worth_um,
            "minutes_of_log_rms_um": {f"{minutes:g}": rms for minutes, rms in self.curve_um.items()},
            "rest_correlates_with": self.correlates,
        }

    def summary(self) -> str:
        """The law in a few lines."""
        kelvin = ", ".join(f"{name} {value:.2f}" for name, value in self.coefficients_um.items())
        hours = sum(float(each.time[-1] - each.time[0]) for each in self.logs) / 3600
        source = f"{len(self.logs)} log{'s' * (len(self.logs) > 1)} of {hours:.3g} h"
        lines = [
            f"{self.law} learnt from {source}{' and the model of the scenario' * (self.plant is not None)}",
            f"µm/K: {kelvin}",
            f"in degC and µm: {self.formula}",
            f"held-out blocks: {self.held_out_um:.2g} µm rms, {self.held_out_worst_um:.2g} µm at most",
        ]
        if self.worth_um:
            costs = ", ".join(f"{name} {max(cost, 0.0):.2g}" for name, cost in self.worth_um.items())
            lines.append(f"leaving out a thermometer costs, in µm rms: {costs}")
        lines.append(self._enough())
        notable = {name: r for name, r in self.correlates.items() if abs(r) >= _NOTABLE}
        if notable:
            listed = ", ".join(f"{name} ({r:+.2f})" for name, r in list(notable.items())[:3])
            lines.append(f"what the law leaves goes with: {listed}")
        return "\n".join(lines)

    def _enough(self) -> str:
        """Sentence on how much log is enough."""
        if self.enough_min is None:
            return "the log is too short to tell whether a longer one would gain"
        curve = ", ".join(f"{minutes:g} min: {rms:.2g}" for minutes, rms in self.curve_um.items())
        return f"{self.enough_min:g} min of log are enough (µm rms of the last third: {curve})"


def learnt_law(
    sources: Logs,
    law: str = "regression",
    sensors: Sequence[str] | None = None,
    *,
    sensor_std: float | None = None,
    sample_time: str | float = 1.0,
    camera_std: float | None = None,
    plant: Plant | None = None,
    model: str = "",
    options: ReadOptions = DEFAULT_OPTIONS,
) -> LearntLaw:
    """Learn a law from logs.

    Parameters
    ----------
    sources : files or DataFrames of one machine, columns as `diagnose` reads them
    law : regression, or an observer, which gets the same map from temperatures to growth
    sensors : thermometers that the law is to use; by default those on the link, and others that are worth it
    sensor_std : noise of a thermometer in K; by default that which the logs show
    sample_time : time between two corrections, in s
    camera_std : noise of the camera in m, for a law that uses it
    plant : a model of the machine that helps where little was measured
    model : what that model is called
    options : units and names of columns

    Raises
    ------
    InputError
        The law cannot be learnt, a file does not fit, or too little was measured.
    """
    if law not in LEARNS:
        raise InputError(f"{argument('law', law)}: is not learnt from a log; {instead(law, LEARNS)}")
    period = positive(sample_time, "s", argument("sample_time"))
    sources = sources_in(sources)
    logs = read_logs(sources, options)
    run: TrainingRun | None = None if plant is None else training_run(plant)
    names = None if sensors is None else [_full(name) for name in sensors]
    found = learn([each.learnt_from for each in logs], names, run, sensor_std)
    files = zip(sources, logs, strict=True)
    told = ", ".join(with_hash(of) if isinstance(of, (str, Path)) else log.name for of, log in files)
    source = f"learnt from {told}" + ("" if plant is None else f" and the model of {model}")
    return LearntLaw(law, found, tuple(logs), period, plant, camera_std, source)


def _short(name: str) -> str:
    return name.removesuffix("_temperature")


def _full(name: str) -> str:
    full = name if name in SENSED else f"{name}_temperature"
    if full not in SENSED:
        known = [_short(each) for each in SENSED]
        raise InputError(f"{argument('sensors', name)}: no such thermometer; {instead(name, known)}")
    return full
