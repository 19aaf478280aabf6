"""What sensors, camera and recorder make of the true outputs, with derivatives.

The same laws as in the components TemperatureSensors and DriftCamera, for readings at any times rather
than at samples:

    T' = T - s (T - T_a),  lag dz/dt = T' - z,  reading = z + offset
    reading of the camera = scale * elongation + drift_rate * time + offset
    a clock offset d shows at time t what was true at t - d
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warmlink.orchestration.diagnosis.data.rig import Rig
from warmlink.orchestration.diagnosis.model.forward import Forward

Vector = NDArray[np.float64]

CLOCK = "record.clock_offset"
"""Not a variable of any FMU: it belongs to the recording."""

_SHORTEST_LAG = 1e-3


@dataclass(frozen=True)
class Channel:
    """The variables of what reads one output; a neutral instrument changes nothing."""

    lag: str
    offset: str
    stem: str
    scale: str
    drift: str


def channel_of(rig: Rig, output: str) -> Channel | None:
    """Variables of the sensor or camera that reads an output; empty names where it has no such variable."""
    reading = rig.readings.get(output)
    if reading is None:
        return None
    if reading == "camera":
        return Channel("", "camera.offset", "", "camera.scale", "camera.drift_rate")
    instance, _, element = reading.partition("[")
    return Channel(
        f"{instance}.lag[{element}",
        f"{instance}.offset[{element}",
        f"{instance}.stem_conduction[{element}",
        "",
        "",
    )


NEUTRAL = {"camera.scale": 1.0}
"""Value that changes nothing, where it is not 0."""


class Readings:
    """Predicts what one run's instruments recorded.

    Parameters
    ----------
    forward : simulates the run
    outputs : outputs that were read, in the order of the equations
    slots : variables of instruments that may be freed; they follow the equations' own
    times : s, rising, shape (times,)
    ambient : logged temperature of the surroundings in K at those times' rows, as (times, values) to hold
    """

    def __init__(
        self,
        forward: Forward,
        outputs: Sequence[str],
        slots: Sequence[str],
        times: Vector,
        ambient: tuple[Vector, Vector],
    ) -> None:
        self.forward, self.times = forward, times
        self._outputs = outputs
        self._slots = {name: i for i, name in enumerate(slots)}
        self._inner = len(forward.equations.slots)
        self._ambient = ambient
        rig = forward.equations.rig
        self._channels = [channel_of(rig, output) for output in outputs]

    def __call__(self, z: Vector) -> tuple[Vector, Vector]:
        """Readings and derivatives.

        Parameters
        ----------
        z : values of the equations' slots and of the instruments', shape (slots,)

        Returns
        -------
        tuple of numpy.ndarray
            Readings in SI, shape (times, outputs), and their derivatives, shape (times, outputs, slots).
        """
        named = {name: float(z[self._inner + i]) for name, i in self._slots.items()}
        late = named.get(CLOCK, 0.0)
        ends = self.forward.steps.time
        asked = np.clip(self.times - late, 0.0, ends[-1])
        lagging = any(c and c.lag and named.get(c.lag, 0.0) > _SHORTEST_LAG for c in self._channels)
        dense = np.union1d(ends, asked) if lagging else asked
        pick = np.searchsorted(dense, asked) if lagging else np.arange(asked.size)
        truth = self.forward(z[: self._inner], dense)
        values = np.empty((asked.size, len(self._outputs)))
        by_slot = np.zeros((*values.shape, z.size))
        within = (self.times - late >= 0) & (self.times - late <= ends[-1])
        for i, channel in enumerate(self._channels):
            joined = np.column_stack([truth.values[:, i], truth.by_slot[:, i]])
            extra: dict[str, Vector] = {}
            slope = truth.slopes[:, i]
            if channel is not None and channel.scale:
                joined, slope = self._camera(channel, named, joined, slope, dense, extra)
            elif channel is not None:
                joined, slope = self._sensor(channel, named, joined, slope, dense, extra)
            values[:, i] = joined[pick, 0]
            by_slot[:, i, : truth.by_slot.shape[2]] = joined[pick, 1:]
            extra[CLOCK] = -slope
            for name, column in extra.items():
                if name in self._slots:
                    by_slot[:, i, self._inner + self._slots[name]] = column[pick]
            if CLOCK in self._slots:
                by_slot[~within, i, self._inner + self._slots[CLOCK]] = 0.0
        return values, by_slot

    def _camera(
        self,
        channel: Channel,
        named: Mapping[str, float],
        joined: Vector,
        slope: Vector,
        times: Vector,
        extra: dict[str, Vector],
    ) -> tuple[Vector, Vector]:
        scale, rate = named.get(channel.scale, 1.0), named.get(channel.drift, 0.0)
        extra[channel.scale], extra[channel.drift] = joined[:, 0].copy(), times
        extra[channel.offset] = np.ones(times.size)
        joined = scale * joined
        joined[:, 0] += rate * times + named.get(channel.offset, 0.0)
        return joined, scale * slope + rate

    def _sensor(
        self,
        channel: Channel,
        named: Mapping[str, float],
        joined: Vector,
        slope: Vector,
        times: Vector,
        extra: dict[str, Vector],
    ) -> tuple[Vector, Vector]:
        stem, lag = named.get(channel.stem, 0.0), named.get(channel.lag, 0.0)
        rows, logged = self._ambient
        ambient = logged[np.clip(np.searchsorted(rows, times, side="right") - 1, 0, rows.size - 1)]
        rise = joined[:, 0] - ambient
        joined = (1 - stem) * joined
        joined[:, 0] += stem * ambient
        slope = (1 - stem) * slope
        by_stem = -rise
        if lag > _SHORTEST_LAG:
            followed = _followed(np.column_stack([joined, by_stem]), times, lag)
            rate = (joined[:, 0] - followed[:, 0]) / lag
            extra[channel.lag] = _followed(-rate[:, None], times, lag, from_rest=True)[:, 0]
            joined, by_stem, slope = followed[:, :-1], followed[:, -1], rate
        else:
            extra[channel.lag] = -slope
        extra[channel.stem] = by_stem
        extra[channel.offset] = np.ones(times.size)
        joined = joined.copy()
        joined[:, 0] += named.get(channel.offset, 0.0)
        return joined, slope


def _followed(signal: Vector, times: Vector, lag: float, from_rest: bool = False) -> Vector:
    """First-order lag of signals that are linear between times, shape (times, signals).

    Settled at the start, or from zero.
    """
    ratio = np.diff(times) / lag
    decay = np.exp(-ratio)
    mean = -np.expm1(-ratio) / ratio
    forced = (1 - mean)[:, None] * signal[1:] + (mean - decay)[:, None] * signal[:-1]
    result = np.empty_like(signal)
    result[0] = 0.0 if from_rest else signal[0]
    state = result[0]
    for k in range(decay.size):
        state = decay[k] * state + forced[k]
        result[k + 1] = state
    return result
