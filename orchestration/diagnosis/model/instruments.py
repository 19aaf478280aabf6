"""Readings of sensors, camera and recorder from the true outputs, with derivatives.

The same laws as in the components TemperatureSensors and DriftCamera, for readings at any times rather
than at samples:

    T' = T - s (T - T_a),  lag dz/dt = T' - z,  reading = scale z + drift_rate * time + offset
    a clock offset d and a drift r show at time t what was true at t (1 + r) - d; T reads c I more in the
    neighbourhood of a cable that carries the motor's current I
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.model.recursions import recursion
from warmlink.orchestration.diagnosis.model.simulation import SimulatedRun, Simulation, parts_before
from warmlink.orchestration.machine.rig import Rig

_Read = tuple[Array, Array, dict[str, Array]]

CLOCK, DRIFT = "record.clock_offset", "record.clock_drift"
"""Not variables of any FMU: they belong to the recording. A logger after a colon: they hold for it alone."""

_SHORTEST_LAG = 1e-3

_FAULTS = {
    **dict.fromkeys(("offset", "crosstalk", "lag", "stem_conduction", "drift_rate"), 0.0),
    "scale": 1.0,
}
"""Faults of a sensor or camera, with the values that change nothing."""


@dataclass(frozen=True)
class Channel:
    """The sensor or camera that reads one output, as `sensors` and `[3]`, and the SI unit of what it reads.

    What is read by none of the system's instruments has one of its own.
    """

    instance: str
    element: str
    unit: str

    @property
    def is_camera(self) -> bool:
        """Whether it reads a growth, as a camera does."""
        return self.unit == "m"

    def variable(self, name: str) -> str:
        """Full name of a variable of the instrument, as `sensors.lag[3]`."""
        return f"{self.instance}.{name}{self.element}"

    def faults(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of the instrument's faults by the name within it, from values by full name."""
        return {**_FAULTS, **{n: values[v] for n in _FAULTS if (v := self.variable(n)) in values}}


def channel_of(rig: Rig, output: str) -> Channel:
    """Sensor or camera that reads an output."""
    instance, bracket, element = rig.readings.get(output, "").partition("[")
    return Channel(instance or f"{output}.reading", bracket + element, rig.unit(output))


def outputs_behind(rig: Rig, read: Sequence[str]) -> tuple[str, ...]:
    """Outputs that make up what was read, each once."""
    return tuple(dict.fromkeys(name for each in read for name in rig.weights(each)))


def _weights(rig: Rig, read: Sequence[str]) -> Array | None:
    """Weights of outputs in what was read, shape (read, outputs); None if each is an output by itself."""
    if not any(each in rig.sums for each in read):
        return None
    behind = outputs_behind(rig, read)
    return np.array([[rig.weights(each).get(name, 0.0) for name in behind] for each in read])


def logger_of(rig: Rig, output: str) -> str:
    """Logger that is likely to record an output: one for each component, and one for the camera."""
    return "camera" if channel_of(rig, output).is_camera else rig.part_of(output)


def neutral(variable: str) -> float:
    """Value of an instrument's variable that changes nothing."""
    return _FAULTS.get(variable.rpartition(".")[2].partition("[")[0], 0.0)


class Readings:
    """Predicts what one run's instruments recorded.

    Parameters
    ----------
    forward : simulates the run
    outputs : what was read: outputs, or weighted sums of outputs
    slots : variables of instruments that may be freed; they follow the equations' own
    times : s, rising, shape (times,)
    """

    def __init__(
        self, forward: Simulation, outputs: Sequence[str], slots: Sequence[str], times: Array
    ) -> None:
        self.forward, self.times, self._inner = forward, times, len(forward.slots)
        self._slots = {name: self._inner + i for i, name in enumerate(slots)}
        self._channels = [channel_of(forward.rig, output) for output in outputs]
        self._sums = _weights(forward.rig, outputs)
        loggers = [logger_of(forward.rig, output) for output in outputs]
        pairs = zip(loggers, outputs, strict=True)
        self._clocks = [(CLOCK, *(f"{CLOCK}:{each}" for each in pair)) for pair in pairs]

    def __call__(self, z: Array, wanted: Sequence[int] | None = None) -> tuple[Array, Array]:
        """Readings and derivatives.

        Parameters
        ----------
        z : values of the equations' slots and of the instruments', shape (slots,)
        wanted : slots by which derivatives are wanted, rising; all without

        Returns
        -------
        tuple of numpy.ndarray
            Readings in SI, shape (times, outputs), and their derivatives, shape (times, outputs, wanted).
        """
        wanted = range(z.size) if wanted is None else wanted
        inner = [i for i in wanted if i < self._inner]
        course = partial(self.forward, wanted=inner)
        values, through, by_fault = self._seen(z, course, self.forward.time, self._around)
        by_slot = np.zeros((*values.shape, len(wanted)))
        by_slot[:, :, : through.shape[2]] = through
        by_slot[:, :, len(inner) :] = by_fault[:, :, [i - self._inner for i in wanted[len(inner) :]]]
        return values, by_slot

    def responses(self, z: Array, courses: Courses) -> Array:
        """Derivatives by the courses' values, shape (times, outputs, values), as `Simulation` has them."""
        return self._summed(self.forward.responses(z[: self._inner], self.times, courses))

    def _summed(self, table: Array) -> Array:
        """What was read of outputs, whose axis is the second."""
        return table if self._sums is None else np.einsum("co,to...->tc...", self._sums, table)

    def sooner(self, z: Array, rows: NDArray[np.int64], parts: int) -> Array:
        """What it does to the readings that inputs act sooner, as `Simulation.sooner` has it."""
        edges = parts_before(self.forward.run, rows, parts)
        course = partial(self.forward.sooner, rows=rows, parts=parts)

        def around(times: Array) -> tuple[Array, Array]:
            later, earlier = edges[:0:-1].T.reshape(-1, 1), edges[-2::-1].T.reshape(-1, 1)
            inside = ((times > earlier) & (times < later)).T
            now, then = self._around(times), self._around(np.repeat(self.forward.run.time[rows], parts))
            ambient, current = (np.hstack([a, inside * (b.T - a)]) for a, b in zip(now, then, strict=True))
            return ambient, current

        return self._seen(z, course, np.append(self.forward.time, edges), around)[1]

    def _around(self, times: Array) -> tuple[Array, Array]:
        """Ambient temperature in K and motor current in A at times, shape (times, 1) each."""
        return self.forward.ambient(times)[:, None], self.forward.current(times)[:, None]

    def _seen(
        self,
        z: Array,
        course: Callable[[Array, Array], SimulatedRun],
        bends: Array,
        around: Callable[[Array], tuple[Array, Array]],
    ) -> tuple[Array, Array, Array]:
        """Readings of a course, of its derivatives, and the derivatives by the instruments' slots.

        The course is given for slots at times; between the bends and the times asked for it is about linear.
        What is `around` the instruments at times may have derivatives beside it, as the course has.
        """
        named = {name: float(z[slot]) for name, slot in self._slots.items()}
        late = [sum(named.get(clock, 0.0) for clock in clocks) for clocks in self._clocks]
        wanted = {lag: self.times * (1 + named.get(DRIFT, 0.0)) - lag for lag in late}
        asked = {lag: np.clip(times, 0.0, self.forward.time[-1]) for lag, times in wanted.items()}
        lagging = any(c.faults(named)["lag"] > _SHORTEST_LAG for c in self._channels)
        dense = asked[late[0]]
        if lagging or len(asked) > 1:
            dense = np.unique(np.concatenate([bends, *asked.values()]))
        truth = course(z[: self._inner], dense)
        truth = SimulatedRun(*map(self._summed, (truth.values, truth.slopes, truth.by_slot)))
        through = np.empty((self.times.size, len(self._channels), 1 + truth.by_slot.shape[2]))
        by_fault = np.zeros((*through.shape[:2], len(self._slots)))
        for i, channel in enumerate(self._channels):
            joined = np.column_stack([truth.values[:, i], truth.by_slot[:, i]])
            faults, there = channel.faults(named), around(dense)
            joined, slope, found = self._read(faults, joined, truth.slopes[:, i], dense, *there)
            pick = np.searchsorted(dense, asked[late[i]])
            through[:, i] = joined[pick]
            moving = np.where(wanted[late[i]] == asked[late[i]], slope[pick], 0.0)
            extra = {channel.variable(name): each[pick] for name, each in found.items()}
            extra |= dict.fromkeys(self._clocks[i], -moving) | {DRIFT: moving * self.times}
            for name in extra.keys() & self._slots.keys():
                by_fault[:, i, self._slots[name] - self._inner] = extra[name]
        return through[:, :, 0], through[:, :, 1:], by_fault

    @staticmethod
    def _read(
        faults: Mapping[str, float], joined: Array, slope: Array, times: Array, ambient: Array, current: Array
    ) -> _Read:
        """Readings beside their derivatives, their slopes in time, and the derivatives by fault."""
        stem, lag, scale, known = faults["stem_conduction"], faults["lag"], faults["scale"], ambient.shape[1]
        by_stem = ambient[:, 0] - joined[:, 0]
        joined = (1 - stem) * joined
        joined[:, :known] += stem * ambient
        slope = (1 - stem) * slope
        by_lag = -slope
        if lag > _SHORTEST_LAG:
            followed = _followed(np.column_stack([joined, by_stem]), times, lag)
            slope = (joined[:, 0] - followed[:, 0]) / lag
            by_lag = _followed(-slope[:, None], times, lag, from_rest=True)[:, 0]
            joined, by_stem = followed[:, :-1].copy(), followed[:, -1]
        by_scale = joined[:, 0].copy()
        joined = scale * joined
        joined[:, :known] += faults["crosstalk"] * current
        joined[:, 0] += faults["offset"] + faults["drift_rate"] * times
        by_fault = {
            "lag": scale * by_lag,
            "stem_conduction": scale * by_stem,
            "scale": by_scale,
            "drift_rate": times,
            "crosstalk": current[:, 0],
            "offset": np.ones(times.size),
        }
        return joined, scale * slope + faults["drift_rate"], by_fault


def _followed(signal: Array, times: Array, lag: float, from_rest: bool = False) -> Array:
    """First-order lag of signals that are linear between times, shape (times, signals).

    Settled at the start, or from zero.
    """
    ratio = np.diff(times) / lag
    decay = np.exp(-ratio)
    mean = -np.expm1(-ratio) / ratio
    forced = (1 - mean)[:, None] * signal[1:] + (mean - decay)[:, None] * signal[:-1]
    begun = 0.0 * signal[:1] if from_rest else signal[:1]
    return recursion(np.vstack([begun, forced]), np.append(decay, 0.0)[None])
