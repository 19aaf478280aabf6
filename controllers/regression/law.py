"""Growth as a linear function of the temperatures measured, fitted from a run.

    correction = c . (T - T_ref),    c = S_eT (S_TT + R)^-1

with S the second moments of temperatures and growth in the run that taught it, and R the sensors' noise: the
linear regression of the shop floor, ridged by the noise. It is computed as a filter, one reading after the
other, for which the moments are the stationary covariance of a process with a memory: a sensor that is
missing then leaves the regression on the others, and a reading that does not fit is noticed.
G. A. F. Seber and A. J. Lee, *Linear Regression Analysis*, 2nd ed., Wiley 2003, chapter 3.
"""

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED, sensed
from warmlink.controllers.kalman import Belief, carried_over, corrected, variance_along
from warmlink.controllers.matrices import diagonal, upper_diagonal
from warmlink.fmus.calls import idle_at_zero, kept_whole
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, exp, maximum, placed, stack, truth, where

SENSORS = len(SENSED)

STATES = SENSORS + 1
"""Temperatures in K above the reference, then the growth in `LENGTH`."""

LENGTH = 1e-5
"""m a kelvin or so: the growth is counted in this, so that the covariance holds numbers of one size."""


LARGEST_GROWTH = 2e-3
"""m; an estimate beyond it is none: the correction is held, and the estimate begins again."""


class Estimate(NamedTuple):
    """Temperatures and growth, shape (6,), and the covariance of their error, packed."""

    mean: Number
    spread: Number


def begin(u: Record, p: Record) -> Values:
    """States at the start: what the first readings say."""
    belief = Estimate(stack(*[0.0] * STATES), p.moments)
    readings = sensed(u)
    belief, trust = sense(belief, fail_safe.at_start(readings), readings, fail_safe.present(readings), p, 0.0)
    return {**_named(belief, trust, 0.0, readings, p), "wild": 0.0, "waited": 0.0}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample."""
    readings = sensed(u)
    news, trust = fail_safe.fresh(fail_safe.trust_of(x), readings, p, step)
    belief, trust = sense(_later(x.estimate, x.spread, p, step), trust, readings, news, p, step)
    sound, belief = _tamed(belief, p)
    wanted = where(sound > 0, LENGTH * belief.mean[SENSORS], x.correction)
    correction = fail_safe.limited(x.correction, wanted, p, step)
    later = {**_named(belief, trust, correction, readings, p), "wild": 1.0 - sound}
    waited = fail_safe.waited_on(x.waited, readings, p, step)
    again = fail_safe.begins_again(x.waited, x.trust_last, readings, p, step)
    kept = {"correction": correction, "waited": waited}
    return fail_safe.begun_again(begin, later | kept, u, p, again) | kept


@kept_whole
def _later(estimate: Number, spread: Number, p: Record, step: Number) -> Estimate:
    """The estimate a sample later, as far as the temperatures are remembered."""
    decay = exp(-step / p.memory_time)
    transition = diagonal(stack(*[decay] * STATES))
    added = p.moments * (1.0 - decay**2)
    return Estimate(decay * estimate, carried_over(spread, transition) + added)


@kept_whole
def _tamed(estimate: Estimate, p: Record) -> tuple[Number, Estimate]:
    """1 where the estimate is one, else 0; and the estimate, which otherwise begins again."""
    sound = truth(absolute(LENGTH * estimate.mean[SENSORS]) <= LARGEST_GROWTH)
    again = Estimate(0.0 * estimate.mean, p.moments)
    return sound, Estimate(*(where(sound > 0, a, b) for a, b in zip(estimate, again, strict=True)))


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m: what the run that taught it left, and the sensors' noise."""
    variance = LENGTH**2 * maximum(upper_diagonal(x.spread, STATES)[SENSORS], 0.0)
    doubt = maximum(x.distrusted, x.wild)
    told = fail_safe.reported(x, (variance + p.residual_std**2) ** 0.5, p, doubt)
    return told | {"warning": maximum(told["warning"], x.wild)}


def sense(
    belief: Estimate, trust: fail_safe.Trust, readings: Number, news: Number, p: Record, step: Number
) -> tuple[Estimate, fail_safe.Trust]:
    """Estimate and trust after the readings, taken one after the other."""
    gates = fail_safe.gates_of(p, step)
    memories = []
    for i in range(SENSORS):
        used = truth(p.sensor_std[i] > 0)
        memory = fail_safe.Memory(trust.mean[i], trust.calm_for[i], trust.out[i])
        rise = readings[i] - p.reference_temperature
        belief, memory = _taken((belief, memory), i, rise, p.sensor_std[i], news[i], gates, step, used)
        memories.append(memory)
    mean, calm, out = (stack(*each) for each in zip(*memories, strict=True))
    return belief, trust._replace(mean=mean, calm_for=calm, out=out)


@idle_at_zero
@kept_whole
def _taken(
    before: tuple[Estimate, fail_safe.Memory],
    sensor: int,
    rise: Number,
    std: Number,
    news: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[Estimate, fail_safe.Memory]:
    """Estimate, and memory of a sensor's innovations, after its reading in K above the reference."""
    estimate, memory = before
    belief = Belief(*estimate, estimate.spread)
    noise = where(std > 0, std**2, 1.0)
    row = placed(1.0, sensor, STATES)
    innovation = rise - belief.mean[sensor]
    variance = variance_along(belief.spread, row) + noise
    use, judged = fail_safe.judged(memory, used * news, innovation, variance, variance, gates, step)
    belief = corrected(belief, row, innovation, noise, use)
    return Estimate(*belief[:2]), fail_safe.Memory(judged.mean, judged.calm_for, used * judged.out)


def _named(
    belief: Estimate, trust: fail_safe.Trust, correction: Number, readings: Number, p: Record
) -> dict[str, Number]:
    return {
        "estimate": belief.mean,
        "spread": belief.spread,
        **fail_safe.trust_named(trust),
        "correction": correction,
        "elongation": LENGTH * belief.mean[SENSORS],
        "distrusted": fail_safe.distrusted(trust, readings, p),
    }
