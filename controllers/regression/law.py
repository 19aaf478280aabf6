"""Growth as a linear function of the temperatures measured, fitted from a run.

    correction = c . (T - T_ref),    c = S_eT (S_TT + R)^-1

with S the second moments of temperatures and growth in the run that taught it, and R the sensors' noise: the
linear regression of the shop floor, ridged by the noise. It is computed as a filter, one reading after the
other, for which the moments are the stationary covariance of a process with a memory: a sensor that is
missing then leaves the regression on the others, and a reading that does not fit is noticed.
G. A. F. Seber and A. J. Lee, *Linear Regression Analysis*, 2nd ed., Wiley 2003, chapter 3.
"""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED, sensed
from warmlink.controllers.kalman import Belief, carried, corrected, variance_along
from warmlink.controllers.matrices import diagonal, upper_diagonal
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, exp, maximum, placed, stack, where

SENSORS = len(SENSED)

STATES = SENSORS + 1
"""Temperatures in K above the reference, then the growth in `LENGTH`."""

LENGTH = 1e-5
"""m a kelvin or so: the growth is counted in this, so that the covariance holds numbers of one size."""


LARGEST_GROWTH = 2e-3
"""m; an estimate beyond it is none: the correction is held, and the estimate begins again."""


def begin(u: Record, p: Record) -> Mapping[str, Number]:
    """States at the start: what the first readings say."""
    belief = Belief(stack(*[0.0] * STATES), p.moments, p.moments)
    readings = sensed(u)
    belief, trust = sense(belief, fail_safe.at_start(readings), readings, fail_safe.present(readings), p, 0.0)
    return {**_named(belief, trust, 0.0, readings, p), "wild": 0.0}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Mapping[str, Number]:
    """States after a sample."""
    moments = p.moments
    decay = exp(-step / p.memory_time)
    transition = diagonal(stack(*[decay] * STATES))
    belief = carried(
        Belief(x.estimate, x.spread, x.spread), transition, decay * x.estimate, moments * (1.0 - decay**2)
    )
    readings = sensed(u)
    news, trust = fail_safe.fresh(fail_safe.trust_of(x), readings, p, step)
    belief, trust = sense(belief, trust, readings, news, p, step)
    sound = absolute(LENGTH * belief.mean[SENSORS]) <= LARGEST_GROWTH
    belief = Belief(
        where(sound, belief.mean, 0.0 * x.estimate),
        where(sound, belief.spread, moments),
        where(sound, belief.noise_spread, moments),
    )
    wanted = where(sound, LENGTH * belief.mean[SENSORS], x.correction)
    correction = fail_safe.limited(x.correction, wanted, p, step)
    return {**_named(belief, trust, correction, readings, p), "wild": where(sound, 0.0, 1.0)}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Correction and its uncertainty in m: what the run that taught it left, and the sensors' noise."""
    variance = LENGTH**2 * maximum(upper_diagonal(x.spread, STATES)[SENSORS], 0.0)
    doubt = maximum(x.distrusted, x.wild)
    told = fail_safe.reported(x, (variance + p.residual_std**2) ** 0.5, p, doubt)
    return told | {"ready": told["ready"] * (1.0 - doubt), "warning": maximum(told["warning"], x.wild)}


def sense(
    belief: Belief, trust: fail_safe.Trust, readings: Number, news: Number, p: Record, step: Number
) -> tuple[Belief, fail_safe.Trust]:
    """Belief and trust after the readings, taken one after the other."""
    gates = fail_safe.gates_of(p)
    means, calm, out = [], [], []
    for i in range(SENSORS):
        used = where(p.sensor_std[i] > 0, 1.0, 0.0)
        noise = where(used > 0, p.sensor_std[i] ** 2, 1.0)
        row = placed(1.0, i, STATES)
        innovation = readings[i] - p.reference_temperature - belief.mean[i]
        variance = variance_along(belief.spread, row) + noise
        signal = fail_safe.Trust(*(each[i] for each in trust))
        verdict = fail_safe.judged(signal, used * news[i], innovation, variance, variance, gates, step)
        belief = corrected(belief, row, innovation, noise, verdict.use)
        means.append(verdict.mean)
        calm.append(verdict.calm_for)
        out.append(used * verdict.out)
    return belief, trust._replace(mean=stack(*means), calm_for=stack(*calm), out=stack(*out))


def _named(
    belief: Belief, trust: fail_safe.Trust, correction: Number, readings: Number, p: Record
) -> dict[str, Number]:
    return {
        "estimate": belief.mean,
        "spread": belief.spread,
        **fail_safe.trust_named(trust),
        "correction": correction,
        "elongation": LENGTH * belief.mean[SENSORS],
        "distrusted": fail_safe.distrusted(trust, readings, p),
    }
