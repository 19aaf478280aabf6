"""Growth as a linear function of the temperatures measured, fitted to a run or learnt from a log.

    growth = intercept + c . (T - T_ref)

The temperatures are those of a filter that takes one reading after the other. Its stationary covariance is
that of the temperatures in the run that the law was fitted to: a thermometer that is missing is then inferred
from the others, and a reading that does not fit is noticed. The growth is smoothed.
G. A. F. Seber and A. J. Lee, *Linear Regression Analysis*, 2nd ed., Wiley 2003, chapters 3 and 5.
"""

from typing import NamedTuple

from warmlink.controllers import fail_safe, leaps, smoothing
from warmlink.controllers.interface import SENSED, SQUARE_MICROMETRE, sensed
from warmlink.controllers.kalman import CrossCovariance, carried_over, gain_of, variance_along
from warmlink.controllers.matrices import diagonal, dot, outer, symmetric, upper
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, exp, maximum, placed, stack, truth, where

SENSORS = len(SENSED)

LARGEST_GROWTH = 2e-3
"""m; an estimate beyond it is none: the correction is held, and the estimate begins again."""


class Estimate(NamedTuple):
    """Temperatures in K above their means, shape (SENSORS,), and their error's covariance in K^2, packed."""

    mean: Number
    spread: Number


def begin(u: Record, p: Record) -> Values:
    """States at the start: what the first readings say."""
    belief = Estimate(stack(*[0.0] * SENSORS), p.moments)
    readings = sensed(u)
    belief, trust = sense(belief, fail_safe.at_start(readings), readings, fail_safe.present(readings), p, 0.0)
    some = fail_safe.in_use(trust, fail_safe.present(readings), p)
    smoothed = smoothing.begun(where(some > 0, grown(belief, p), 0.0))
    states = _named(belief, trust, 0.0, smoothed, readings, p)
    return {**states, **leaps.none(readings), "wild": 0.0, "waited": 0.0}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample."""
    readings = sensed(u)
    before = fail_safe.trust_of(x)
    news, trust = fail_safe.fresh(before, readings, p, step)
    belief, trust = sense(_later(x.estimate, x.spread, p, step), trust, readings, news, p, step)
    sound, belief = _tamed(belief, p)
    # Where no thermometer tells anything, the mean of what was learnt is no news.
    known = sound * fail_safe.in_use(trust, fail_safe.present(readings), p)
    growth = where(known > 0, grown(belief, p), x.smoothed[0])
    smoothed = smoothing.smoothed(x.smoothed, growth, p, step)
    wanted = where(known > 0, smoothing.on_time(smoothed), x.correction)
    correction = fail_safe.limited(x.correction, wanted, p, step)
    states = _named(belief, trust, correction, smoothed, readings, p)
    later = {**states, **leaps.later(x, readings, before, p, step), "wild": 1.0 - sound}
    waited = fail_safe.waited_on(x.waited, readings, p, step)
    again = fail_safe.begins_again(x.waited, x.trust_last, readings, p, step)
    kept = {"correction": correction, "waited": waited}
    return fail_safe.begun_again(begin, later | kept, u, p, again) | kept


def grown(belief: Estimate, p: Record) -> Number:
    """Growth in m at the temperatures of an estimate."""
    return p.intercept + dot(p.coefficients, p.mean_rise + belief.mean)


@as_c_function
def _later(estimate: Number, spread: Number, p: Record, step: Number) -> Estimate:
    """The estimate a sample later, as far as the temperatures are remembered."""
    decay = exp(-step / p.memory_time)
    transition = diagonal(stack(*[decay] * SENSORS))
    added = p.moments * (1.0 - decay**2)
    return Estimate(decay * estimate, carried_over(spread, transition) + added)


@as_c_function
def _tamed(estimate: Estimate, p: Record) -> tuple[Number, Estimate]:
    """1 if the estimate is plausible, else 0; and the estimate, which otherwise begins again."""
    sound = truth(absolute(grown(estimate, p)) <= LARGEST_GROWTH)
    again = Estimate(0.0 * estimate.mean, p.moments)
    return sound, Estimate(*(where(sound > 0, a, b) for a, b in zip(estimate, again, strict=True)))


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction, and its uncertainty in m: a prediction interval (Seber and Lee, section 5.3).

    The noise of the readings, what the law leaves of growth that it was not fitted to, and the doubt about
    its coefficients, which grows with the distance from the temperatures that it was fitted to.
    """
    variance = variance_along(x.spread, p.coefficients) + p.residual_std**2
    variance = variance + SQUARE_MICROMETRE * variance_along(p.coefficient_spread, x.estimate)
    doubt = maximum(maximum(x.distrusted, leaps.leapt(x)), x.wild)
    reported = fail_safe.reported(x, variance**0.5, p, doubt)
    return reported | {"warning": maximum(reported["warning"], x.wild)}


def sense(
    belief: Estimate, trust: fail_safe.Trust, readings: Number, news: Number, p: Record, step: Number
) -> tuple[Estimate, fail_safe.Trust]:
    """Estimate and trust after the readings, taken one after the other."""
    gates = fail_safe.gates_of(p, step)
    memories = []
    for i in range(SENSORS):
        used = truth(p.sensor_std[i] > 0)
        memory = fail_safe.Memory(trust.mean[i], trust.calm_for[i], trust.out[i])
        rise = readings[i] - p.reference_temperature - p.mean_rise[i]
        row = placed(1.0, i, SENSORS)
        belief, memory = _taken((belief, memory), row, rise, p.sensor_std[i], news[i], gates, step, used)
        memories.append(memory)
    mean, calm, out = (stack(*each) for each in zip(*memories, strict=True))
    return belief, trust._replace(mean=mean, calm_for=calm, out=out)


@skip_if_zero
@as_c_function
def _taken(
    before: tuple[Estimate, fail_safe.Memory],
    row: Number,
    rise: Number,
    std: Number,
    news: Number,
    gates: fail_safe.Gates,
    step: Number,
    used: Number,
) -> tuple[Estimate, fail_safe.Memory]:
    """Estimate, and memory of a sensor's innovations, after its reading in K above its mean.

    The row is 1 for that sensor, and 0 for all others.
    """
    estimate, memory = before
    noise = where(std > 0, std**2, 1.0)
    innovation = rise - dot(row, estimate.mean)
    across = symmetric(estimate.spread, SENSORS) @ row
    variance = maximum(dot(row, across), 0.0) + noise
    use, after = fail_safe.gate_reading(memory, used * news, innovation, variance, variance, gates, step)
    gain = gain_of(row, CrossCovariance(across, across), innovation, noise, use)
    mean = estimate.mean + across * gain.times
    spread = estimate.spread - upper(outer(across * gain.share, across))
    return Estimate(mean, spread), fail_safe.Memory(after.mean, after.calm_for, used * after.out)


def _named(
    belief: Estimate,
    trust: fail_safe.Trust,
    correction: Number,
    smoothed: Number,
    readings: Number,
    p: Record,
) -> dict[str, Number]:
    return {
        "estimate": belief.mean,
        "spread": belief.spread,
        **fail_safe.trust_named(trust),
        "correction": correction,
        "smoothed": smoothed,
        "elongation": smoothing.on_time(smoothed),
        "distrusted": fail_safe.distrusted(trust, readings, p),
    }
