"""What a law leaves of the growth: the one whose correction is logged, or a law of ours in shadow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.controllers.interface import SENSED
from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance, Snapshot
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.catalogue import controller_named
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.scenarios.overrides import parameters_of, start_values
from warmlink.orchestration.watch.filter.shadow import CLIPPED
from warmlink.orchestration.watch.ticks import Tick

_DUTY = ("speed", "torque", "ambient_temperature")

_DRIFT, _VALID = "measured_drift", "drift_valid"

_LEAST = 1e-7
"""m of scatter of a law's error below which none is believed."""


@dataclass(frozen=True)
class WatchedLaw:
    """A law of ours that runs in shadow: its name, and its component with start values of its parameters."""

    name: str
    component: Component

    @property
    def facts(self) -> list[str | float]:
        """What a restart has to ask for as well, as JSON."""
        return [self.name, *self.component.start_values()[0].tolist()]


def law_named(name: str, parameters: str | Path | None) -> WatchedLaw:
    """A law by name, with the values of a parameter set (SSV).

    Raises
    ------
    InputError
        There is no such law, or a parameter does not fit.
    """
    found = controller_named(name)
    law, where = found.component, argument("controller_parameters", parameters or "")
    values = {} if parameters is None else parameters_of(Path(parameters))
    own = start_values(values, {COMPENSATOR: law}, where).get(COMPENSATOR, {})
    scalars = {each: float(value) for each, value in own.items()}
    return WatchedLaw(found.name, replace(law, parameters=with_scalars(law.parameters, scalars)))


def law_error(
    law: WatchedLaw | None, rig: Rig, outputs: Sequence[str], is_logged: bool, tick: float
) -> LawError | None:
    """What is judged of a law; None if none is run or logged.

    Raises
    ------
    InputError
        A law is to run, but the growth that it should take out is not measured.
    """
    if law is None and not is_logged:
        return None
    weights = growth_weights(rig, outputs)
    if weights is None:
        if law is None:
            return None
        needed = ", ".join(rig.machine.growth) or "a growth, which this machine does not say"
        raise InputError(
            f"{argument('controller', law.name)}: a law is judged by the growth that it leaves; log {needed}"
        )
    return LawError(weights, None if law is None else ShadowLaw(law.component, rig, outputs, tick))


def growth_weights(rig: Rig, outputs: Sequence[str]) -> Array | None:
    """Weight of each reading in the growth that a law should take out; None if part of it is not measured."""
    growth = rig.machine.growth
    if not growth or any(name not in outputs for name in growth):
        return None
    return np.array([growth.get(name, 0.0) for name in outputs])


class ShadowLaw:
    """A law that sees what the machine's own would, a sample in each tick; its correction goes nowhere.

    Parameters
    ----------
    law : with the start values of its parameters
    rig : the machine
    outputs : what is measured, in order
    tick : s of the log in one tick

    Raises
    ------
    InputError
        The machine has none of the thermometers that laws read, or the law refuses a parameter.
    """

    def __init__(self, law: Component, rig: Rig, outputs: Sequence[str], tick: float) -> None:
        if "sample_time" in law.p.index:
            law = replace(law, parameters=with_scalars(law.parameters, {"sample_time": tick}))
        columns = {n: rig.columns[n] for n in (*SENSED, *_DUTY) if n in rig.columns and n in law.u.index}
        self._read = {n: outputs.index(v) for n, v in columns.items() if v in outputs}
        self._fed = {n: rig.externals.index(v) for n, v in columns.items() if v in rig.externals}
        if not self._read:
            raise InputError(
                f"{law.name}: none of its thermometers is logged; log at least one of {', '.join(columns)}"
            )
        self._unread = [n for n in SENSED if n in law.u.index and n not in self._read]
        self._law, self._tick, self._samples = law, tick, 0
        self._instance = self._fresh()

    def _fresh(self) -> Instance:
        instance = Instance(self._law, "law")
        instance.set(dict.fromkeys(self._unread, np.nan))
        return instance

    def step(self, tick: Tick, growth: float) -> tuple[float, bool]:
        """Take a tick with its growth in m; give the correction in m at its end, and whether it is ready.

        A law with a camera sees the growth less its own correction so far.
        """
        means = tick.shares @ tick.levels
        given = {name: float(means[i]) for name, i in self._fed.items()}
        given |= {name: float(tick.readings[i]) for name, i in self._read.items()}
        if tick.anew or not self._samples:
            self._instance, self._samples = self._fresh(), 0
            self._instance.set(given)
            self._instance.initialize()
        if _DRIFT in self._law.u.index and np.isfinite(growth):
            given |= {_DRIFT: growth - self._instance.get("correction"), _VALID: 1.0}
        self._instance.set(given)
        count = max(1, round((tick.end - tick.start) / self._tick))
        for _ in range(min(count, 60)):
            self._instance.step(self._samples * self._tick, self._tick)
            self._samples += 1
        return self._instance.get("correction"), self._instance.get("ready") > 0.5

    def state(self) -> dict[str, Any]:
        """What a restart needs, as JSON."""
        return {"samples": self._samples, "snapshot": asdict(self._instance.snapshot())}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a state that `state` gave."""
        self._samples = state["samples"]
        if self._samples:
            self._instance.restore(Snapshot(**state["snapshot"]))


_OWN = ("mean", "std", "last", "ready", "opening")


@dataclass
class LawError:
    """Growth that a law leaves, as a share of how it scatters in the sound part.

    Parameters
    ----------
    weights : of each reading in the growth, as `growth_weights` gives them
    law : that is run; None to take the correction that is logged

    Attributes
    ----------
    mean, std : of the error in the sound part, in m; None before
    last, ready : error in m and whether the law says it is ready, at the last tick; NaN if it is not known
    """

    weights: Array
    law: ShadowLaw | None = None
    mean: float | None = None
    std: float = _LEAST
    last: float = np.nan
    ready: bool | None = None
    opening: list[float] = field(default_factory=list)

    def add(self, tick: Tick) -> float:
        """Error in m of a tick, NaN if growth or correction is not known."""
        used, correction = self.weights != 0, tick.correction
        growth = float(self.weights[used] @ tick.readings[used])
        if self.law is not None:
            correction, self.ready = self.law.step(tick, growth)
        self.last = growth - correction
        return self.last

    def state(self) -> dict[str, Any]:
        """What a restart needs, as JSON."""
        own = {name: getattr(self, name) for name in _OWN}
        return {**own, "law": None if self.law is None else self.law.state()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from a state that `state` gave."""
        for name in _OWN:
            setattr(self, name, state[name])
        if self.law is not None:
            self.law.restore(state["law"])

    @property
    def shift(self) -> float:
        """By how much it leaves another growth in m now than in the sound part; NaN if it is not known."""
        return self.last - (self.mean or 0.0)

    def learn(self) -> list[float]:
        """Learn from what has come so far, which it gives back and forgets."""
        errors, self.opening = self.opening, []
        there = np.array([each for each in errors if np.isfinite(each)])
        if there.size:
            self.mean, self.std = float(there.mean()), max(float(there.std()), _LEAST)
        return errors

    def leans(self, errors: float | Sequence[float]) -> tuple[Array, Array]:
        """How far errors in m lean, in standard deviations of the sound part, and 1 where they are known."""
        error = np.asarray(errors, dtype=float)
        known = np.isfinite(error) & (self.mean is not None)
        lean = (np.where(known, error, 0.0) - (self.mean or 0.0)) / self.std
        return np.where(known, np.clip(lean, -CLIPPED, CLIPPED), 0.0), np.asarray(known, dtype=float)
