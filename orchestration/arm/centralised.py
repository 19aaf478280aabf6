"""One observer over all axes: a Kalman filter on the whole chain, run on the readings of a recorded run.

It knows what six independent observers do not: that a warm joint warms the tip of the link before it. Its
corrections act back on nothing that a thermometer sees, so that it may as well be run afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from warmlink.controllers.design.chain import Chain, chain_model
from warmlink.controllers.design.gains import Unknown
from warmlink.controllers.design.plant import OUTPUTS, Plant, parameter_vector
from warmlink.controllers.observer.model import MODES
from warmlink.fmus.motor_heat_source import equations as motor
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR

Array = NDArray[np.float64]

SAMPLE = 10
"""Communication steps over which readings are averaged before the filter takes them."""


@dataclass(frozen=True)
class Readings:
    """What the filter may know, at the communication points.

    Attributes
    ----------
    step : communication step size in s
    speed, torque : of each joint in rad/s and N.m, shape (n, axes)
    ambient : temperature of the surroundings in K, shape (n,)
    temperature : reading of each axis's one sensor in K, NaN where there is none, shape (n, axes)
    """

    step: float
    speed: Array
    torque: Array
    ambient: Array
    temperature: Array


class CentralisedObserver:
    """Kalman filter on a chain of axes.

    Parameters
    ----------
    plants : parameters of each axis, from the base outwards
    sensor : which temperature each axis's sensor takes, as `middle_temperature`
    sensor_std : standard deviation of a reading in K
    unknown : what the designer does not know; as for the observer of one axis
    """

    def __init__(
        self, plants: Sequence[Plant], sensor: str, sensor_std: float, unknown: Unknown | None = None
    ) -> None:
        self.chain: Chain = chain_model(plants, MODES)
        self._unknown = unknown or Unknown()
        self._motors = [MOTOR.p.read(parameter_vector(MOTOR, plant.motor, "motor")) for plant in plants]
        self._count = len(plants)
        self._sensors = np.array([self._row(i, sensor) for i in range(self._count)])
        self._elongation = np.array([self._row(i, "elongation") for i in range(self._count)])
        self._variance = sensor_std**2
        self._models: dict[tuple[float, ...], _Model] = {}

    @property
    def size(self) -> int:
        """Number of states: modes, and two unknown heats an axis."""
        return self.chain.order + 2 * self._count

    def run(self, known: Readings) -> Array:
        """Estimated elongations in m at the communication points, shape (n, axes).

        The estimate made at a point holds until the filter's next sample.
        """
        points = known.temperature.shape[0]
        estimate = np.zeros((points, self._count))
        mean, spread = np.zeros(self.size), self._start()
        window = SAMPLE * known.step
        for begin in range(0, points - 1, SAMPLE):
            estimate[begin : begin + SAMPLE] = self._elongation @ mean
            end = min(begin + SAMPLE, points - 1)
            model = self._model(tuple(np.abs(known.speed[begin])), window)
            before = mean
            heat = self._heat(mean, known.speed[begin], known.torque[begin])
            rise = np.full(self._count, known.ambient[begin] - self.chain.temperature)
            mean = model.transition @ mean + model.reach @ np.concatenate([heat, rise])
            spread = model.transition @ spread @ model.transition.T + model.noise
            readings = known.temperature[begin + 1 : end + 1] - self.chain.temperature
            # Readings are means over the window, hence held against the prediction's mean over it.
            innovation = _means(readings) - self._sensors @ (before + mean) / 2
            mean, spread = self._corrected(mean, spread, innovation, len(readings))
        estimate[-1] = self._elongation @ mean
        return estimate

    def _row(self, axis: int, output: str) -> Array:
        return np.concatenate([self.chain.row(axis, output), np.zeros(2 * self._count)])

    def _start(self) -> Array:
        """Doubt at a cold start: a common temperature, and unknown heat of the designed size."""
        unknown, order = self._unknown, self.chain.order
        spread = np.zeros((self.size, self.size))
        # Everything 1 K warmer is where surroundings 1 K warmer lead to.
        still = [0.0] * self._count
        uniform = -np.linalg.solve(
            self.chain.state_matrix(still), self.chain.input_matrix(still, "ambient_temperature").sum(axis=1)
        )
        spread[:order, :order] = unknown.uniform**2 * np.outer(uniform, uniform)
        spread[order:, order:] = np.diag(self._heat_sizes() ** 2)
        return spread

    def _heat_sizes(self) -> Array:
        return np.repeat([self._unknown.shaft_heat, self._unknown.link_heat], self._count)

    def _heat_times(self) -> Array:
        return np.repeat([self._unknown.shaft_heat_time, self._unknown.link_heat_time], self._count)

    def _heat(self, mean: Array, speed: Array, torque: Array) -> Array:
        """Losses in W of all windings, then of all shafts, by the motors' own equations."""
        winding, shaft = [], []
        for i, p in enumerate(self._motors):
            place, axis = self.chain.place(i), self.chain.axes[i]
            modes = mean[: self.chain.order][place]
            temperatures = axis.C @ modes + self.chain.temperature
            u = MOTOR.u.read(np.zeros(MOTOR.u.size))._replace(speed=speed[i], torque=torque[i])
            winding.append(
                motor.copper_loss(temperatures[OUTPUTS.index("winding_temperature")], u, p)
                + motor.iron_loss(u, p)
            )
            shaft.append(
                motor.friction_loss(temperatures[OUTPUTS.index("shaft_temperature")], u, p) + p.standby_power
            )
        return np.array(winding + shaft)

    def _model(self, speeds: tuple[float, ...], window: float) -> _Model:
        if speeds not in self._models:
            self._models[speeds] = self._discrete(speeds, window)
        return self._models[speeds]

    def _discrete(self, speeds: tuple[float, ...], window: float) -> _Model:
        """Exact over a window in which speeds and heats are held; the noise by Van Loan's method."""
        order, size = self.chain.order, self.size
        into = {
            name: self.chain.input_matrix(speeds, name)
            for name in ("winding_heat", "shaft_heat", "link_heat", "ambient_temperature")
        }
        state = np.zeros((size, size))
        state[:order, :order] = self.chain.state_matrix(speeds)
        state[:order, order:] = np.hstack([into["shaft_heat"], into["link_heat"]])
        state[order:, order:] = -np.diag(1 / self._heat_times())
        given = np.zeros((size, 3 * self._count))
        given[:order] = np.hstack([into["winding_heat"], into["shaft_heat"], into["ambient_temperature"]])

        width = given.shape[1]
        block = np.zeros((size + width, size + width))
        block[:size] = np.hstack([state, given])
        whole = linalg.expm(block * window)
        power = np.zeros((size, size))
        power[order:, order:] = np.diag(2 * self._heat_sizes() ** 2 / self._heat_times())
        # C. F. Van Loan, IEEE Trans. Automatic Control 23 (1978) 395-404.
        loan = linalg.expm(np.block([[-state, power], [np.zeros_like(state), state.T]]) * window)
        transition = loan[size:, size:].T
        return _Model(transition, whole[:size, size:], transition @ loan[:size, size:])

    def _corrected(self, mean: Array, spread: Array, innovation: Array, count: int) -> tuple[Array, Array]:
        there = np.isfinite(innovation)
        rows = self._sensors[there]
        if not rows.size:
            return mean, spread
        noise = np.eye(len(rows)) * self._variance / count
        gain = np.linalg.solve(rows @ spread @ rows.T + noise, rows @ spread).T
        rest = np.eye(self.size) - gain @ rows
        # Joseph's form keeps the covariance symmetric and positive.
        return mean + gain @ innovation[there], rest @ spread @ rest.T + gain @ noise @ gain.T


@dataclass(frozen=True)
class _Model:
    """One window of time: transition, effect of held inputs, covariance of what is unknown."""

    transition: Array
    reach: Array
    noise: Array


def _means(readings: Array) -> Array:
    """Mean of what there is in each column, NaN where there is nothing."""
    there = np.isfinite(readings)
    count = there.sum(axis=0)
    total = np.where(there, readings, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
