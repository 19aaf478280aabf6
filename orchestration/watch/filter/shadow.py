"""The plant's own filter in shadow: an extended Kalman filter on the joined machine, tick after tick.

Its states are the plant's, what nobody logged of the room and of heat, and by how much the model is off at
each reading; the latter two follow Ornstein-Uhlenbeck processes whose sizes were learnt from the sound part.
They are stronger while work is not what it was of late, as when a cold machine begins: there a model errs
most. And rows do not say when between them work began or ended: in a tick in which it did, that moment is a
state too, of a size that was learnt.
A reading is a mean over a tick, between the outputs at its ends. So each tick first corrects the state at
its start, with what the readings within it say, and then goes on to its end.

Beside the state goes what each hypothesis would have changed in what the filter expects, had it been true all
along: the direction in which the innovations would then lean (A. S. Willsky and H. L. Jones, "A generalized
likelihood ratio approach to the detection and estimation of jumps in linear systems", IEEE Transactions on
Automatic Control 21, 1976).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.model.integrator import Courses, Integrator, Steps
from warmlink.orchestration.diagnosis.model.simulation import initial_values
from warmlink.orchestration.watch.filter.drives import Drives
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.hypotheses import WatchedMachine
from warmlink.orchestration.watch.ticks import Tick

CLIPPED = 5.0
"""Standard deviations beyond which an innovation counts as this much: one wild reading is no fault."""

_STEP = 60.0
"""s of an integration step, at most."""


class LinearTick(NamedTuple):
    """A tick as the filter saw it, for learning: linear about its own estimate.

    Attributes
    ----------
    error : readings minus expected ones, shape (outputs,); NaN where there is none
    seen : derivatives of the readings by the state at the start, shape (outputs, n)
    onward : state at the end by the state at the start, shape (n, n)
    pushed : what a unit of each hypothesis adds to the state at the end, shape (n, hypotheses)
    direct : what it adds to the readings, shape (outputs, hypotheses)
    counts, lasting : readings in each mean, and length of the tick in s
    correction : of the state at the start, that the filter made, shape (n,)
    anew : whether the filter began with it
    driven : lags of what drives the machine, shape (lags,)
    stirred : how far work is from what it was of late, as `Drives.stirred`
    """

    error: Array
    seen: Array
    onward: Array
    pushed: Array
    direct: Array
    counts: Array
    lasting: float
    correction: Array
    anew: bool
    driven: Array
    stirred: Array


class Innovation(NamedTuple):
    """What a tick says: innovations in standard deviations, and which way they would lean by each hypothesis.

    Attributes
    ----------
    white : whitened innovations, shape (outputs,); NaN where nothing was read
    rows : the same, clipped, and behind them their directions by hypothesis, shape (readings, 1 + hypotheses)
    expected, sigma : reading that was expected and its standard deviation in SI, shape (outputs,)
    """

    white: Array
    rows: Array
    expected: Array
    sigma: Array


class Shadow:
    """The filter.

    Parameters
    ----------
    machine : what is watched
    noise : as learnt
    values : of the slots as calibrated, shape (slots,)
    offsets : of the readings as calibrated, shape (outputs,)
    weights : by which lags of what drives the machine add to the readings, shape (outputs, lags)

    Attributes
    ----------
    x : states of the plant, shape (plant,)
    rest : wandering signals, by how much a switch came early or late, misfits, shape (signals + 1 + outputs,)
    P : covariance of both, shape (n, n)
    directions : what each hypothesis has changed, shape (n, hypotheses)
    lags : of what drives the machine, shape (lags,)
    clipped : standard deviations beyond which an innovation counts as this much
    """

    def __init__(
        self, machine: WatchedMachine, noise: ShadowNoise, values: Array, offsets: Array, weights: Array
    ) -> None:
        self.machine, self.noise, self.values, self.offsets = machine, noise, values, offsets
        self.weights, self._drives = weights, Drives(machine.rig, machine.inputs, machine.tick)
        self.clipped = CLIPPED
        self.plant, self.signals = len(machine.equations.states), machine.wander.shape[1]
        self.outputs, self.size = len(machine.outputs), self.plant + self.signals + 1 + len(machine.outputs)
        self._groups = np.column_stack([machine.wander, machine.groups])
        self._reading = np.array([each.reading for each in machine.hypotheses]).T
        self._late = np.array([each.late for each in machine.hypotheses]).T
        count = machine.slots.size
        self._courses = Courses((((),) * self.plant) + tuple((i,) for i in range(count)), np.zeros(1))
        self._p = self.parameters({})
        self.x, self.lags = np.zeros(0), np.zeros(0)
        self.rest, self.P, self.directions = np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0))

    def parameters(self, start: dict[str, float]) -> Array:
        """Values of all parameters, with those that set the states at the start."""
        rig, known = self.machine.rig, {**self.machine.known, **start}
        usual = self.machine.equations.parameter_values
        return np.array([known.get(n, v) for n, v in zip(rig.parameters, usual, strict=True)], dtype=float)

    def begin(self, tick: Tick) -> None:
        """Start from a tick's readings, of which hardly anything is known beside them."""
        read = {
            n: np.repeat(v, 2)
            for n, v in zip(self.machine.outputs, tick.readings, strict=True)
            if np.isfinite(v)
        }
        run = Run("start", np.array([0.0, 1.0]), {}, read)
        p = self.parameters(initial_values(self.machine.rig, run, self.machine.known))
        self.x, _ = self.machine.equations.begin(self.values, p, tick.levels[-1])
        self.rest = np.zeros(self.size - self.plant)
        self.P = self.noise.at_start(self.plant)
        self.directions = np.zeros((self.size, len(self.machine.hypotheses)))
        self.lags = self._drives.begin(tick)

    def step(self, tick: Tick) -> tuple[Innovation, LinearTick]:
        """Take a tick: what it says, and the same as learning takes it."""
        anew = tick.anew or not self.x.size
        if anew:
            self.begin(tick)
        expected, seen, onward, pushed, direct, reached = self._ahead(tick)
        stirred = self._drives.stirred(self.lags, tick, self.noise.usual)
        before, self.lags = self.lags, self._drives.onward(self.lags, tick)
        driven = (before + self.lags) / 2
        expected = expected + self.weights @ driven
        error = tick.readings - expected
        lasting = tick.end - tick.start
        said, correction, gain = corrected(
            error,
            seen,
            self.P,
            self.noise.variances(tick.counts),
            direct + seen @ self.directions,
            self.clipped,
        )
        self.directions = onward @ (self.directions - gain @ said.leaning) + pushed
        self.rest = self.rest + correction[self.plant :]
        self.x = reached + onward[: self.plant] @ correction
        self.rest = np.diag(onward)[self.plant :] * self.rest
        self.P = onward @ said.covariance @ onward.T + np.diag(
            self.noise.process(self.plant, lasting, stirred)
        )
        innovation = Innovation(said.white, said.rows, expected, said.sigma)
        return innovation, LinearTick(
            error, seen, onward, pushed, direct, tick.counts, lasting, correction, anew, driven, stirred
        )

    def _ahead(self, tick: Tick) -> tuple[Array, Array, Array, Array, Array, Array]:
        """Expected readings, derivatives as in `LinearTick`, and the plant's states at the end."""
        equations, n, lasting = self.machine.equations, self.plant, tick.end - tick.start
        wandering = self.rest[: self.signals]
        z = self.values + self.machine.wander @ wandering
        count, levels = max(1, int(np.ceil(lasting / _STEP - 1e-9))), len(tick.levels)
        each = np.arange(levels)
        time = np.linspace(0.0, lasting, count + 1)
        steps = Steps(
            time,
            np.ascontiguousarray(tick.levels),
            np.arange(0, (count + 1) * levels, levels),
            np.tile(each, count),
            np.tile(tick.shares, count),
        )
        begun = np.column_stack([self.x, np.eye(n), np.zeros((n, self._groups.shape[0]))])
        states, _, _ = Integrator(equations, z, self._p, self._courses)(steps, begun)
        reached, by_state = states[-1, :, 0], states[-1, :, 1 : n + 1]
        by_group = states[-1, :, n + 1 :] @ self._groups
        switched = self._switched(steps, z, reached)
        inputs = np.column_stack([tick.levels[0], tick.levels[-1]])
        y, rows, by_slot = equations.observe(
            np.column_stack([self.x, reached]), z, self._p, inputs, np.array([0.0, lasting])
        )
        at = tick.places[:, None]
        misfit, memory = self.rest[self.signals + 1 :], self.noise.kept(lasting)
        expected = (1 - tick.places) * y[0] + tick.places * y[1] + self.offsets + misfit
        through = at * (rows[1] @ by_group) + by_slot[1] @ self._groups
        by_switch = at * (rows[1] @ switched)[:, None]
        seen = np.column_stack(
            [
                (1 - at) * rows[0] + at * (rows[1] @ by_state),
                through[:, : self.signals],
                by_switch,
                np.eye(self.outputs),
            ]
        )
        onward = np.zeros((self.size, self.size))
        onward[:n, :n], onward[:n, n : n + self.signals] = by_state, by_group[:, : self.signals]
        onward[:n, n + self.signals] = switched
        onward[np.arange(n, self.size), np.arange(n, self.size)] = memory
        pushed = np.zeros((self.size, self._groups.shape[1] - self.signals))
        pushed[:n] = by_group[:, self.signals :]
        slope = (y[1] - y[0]) / lasting
        direct = through[:, self.signals :] + self._reading - self._late * slope[:, None]
        return expected, seen, onward, pushed, direct, reached

    def _switched(self, steps: Steps, z: Array, reached: Array) -> Array:
        """What a s more of the highest level of the inputs, and less of the lowest, adds to the states.

        As when work began or ended a s before or after the row that says so.
        """
        count = steps.inputs.shape[0]
        if count == 1:
            return np.zeros(self.plant)
        shares = steps.shares.copy()
        shares[::count] -= 1.0 / steps.time[-1]
        shares[count - 1 :: count] += 1.0 / steps.time[-1]
        moved = Integrator(self.machine.equations, z, self._p)(
            replace(steps, shares=shares), self.x[:, None].copy()
        )
        return moved[0][-1, :, 0] - reached


class Corrected(NamedTuple):
    """What readings make of a state.

    Attributes
    ----------
    white : whitened innovations, NaN where there is none, shape (outputs,)
    covariance : of the state after them, shape (n, n)
    sigma : standard deviation of each expected reading, NaN where there is none, shape (outputs,)
    leaning : direction of the innovations that are there by hypothesis, shape (readings, hypotheses)
    rows : the same, whitened, behind the whitened innovations, shape (readings, 1 + hypotheses)
    likelihood : twice the logarithm of it, but for a constant
    """

    white: Array
    covariance: Array
    sigma: Array
    leaning: Array
    rows: Array
    likelihood: float


def corrected(
    error: Array, seen: Array, P: Array, variances: Array, leaning: Array, clipped: float = CLIPPED
) -> tuple[Corrected, Array, Array]:
    """Correct a state with readings that are there.

    Parameters
    ----------
    error : readings minus expected, NaN where there is none, shape (outputs,)
    seen : derivatives by state, shape (outputs, n)
    P : covariance of the state, shape (n, n)
    variances : of the readings' noise, shape (outputs,)
    leaning : direction of the innovations by hypothesis, shape (outputs, hypotheses)
    clipped : standard deviations beyond which an innovation counts as this much

    Returns
    -------
    tuple
        `Corrected`; the correction, shape (n,); the gain, shape (n, readings).
    """
    there = np.flatnonzero(np.isfinite(error))
    H, spread = seen[there], P @ seen[there].T
    S = H @ spread + np.diag(variances[there])
    lower = np.linalg.cholesky(S)
    whiten = np.linalg.inv(lower)
    whitened = whiten @ np.column_stack([error[there], leaning[there]])
    counted = np.clip(whitened[:, 0], -clipped, clipped)
    gain = spread @ whiten.T @ whiten
    white, sigma = np.full(error.size, np.nan), np.full(error.size, np.nan)
    white[there], sigma[there] = whitened[:, 0], np.sqrt(np.diag(S))
    log = -2.0 * float(np.log(np.diag(lower)).sum()) - float(
        np.minimum(whitened[:, 0] ** 2, CLIPPED**2).sum()
    )
    rows = np.column_stack([counted, whitened[:, 1:]])
    found = Corrected(white, P - gain @ S @ gain.T, sigma, leaning[there], rows, log)
    return found, gain @ (lower @ counted), gain
