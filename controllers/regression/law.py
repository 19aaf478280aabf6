"""Growth as a linear function of the temperatures measured, fitted to a run or learnt from a log.

    growth = intercept + c . (T - T_ref)

The temperatures are those of a filter that takes one reading after the other. Its stationary covariance is
that of the temperatures in the run that the law was fitted to: a thermometer that is missing is then inferred
from the others, and a reading that does not fit is noticed. The growth is smoothed.
G. A. F. Seber and A. J. Lee, *Linear Regression Analysis*, 2nd ed., Wiley 2003, chapters 3 and 5.
"""

from warmlink.controllers import fail_safe, leaps, smoothing
from warmlink.controllers.estimate import Estimate, sense
from warmlink.controllers.interface import SENSED, SQUARE_MICROMETRE, sensed
from warmlink.controllers.kalman import carried_over, variance_along
from warmlink.controllers.matrices import diagonal, dot
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, exp, maximum, placed, stack, truth, where

SENSORS = len(SENSED)

LARGEST_GROWTH = 2e-3
"""m; an estimate beyond it is none: the correction is held, and the estimate begins again."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: what the first readings say."""
    belief = Estimate(stack(*[0.0] * SENSORS), p.moments)
    readings = sensed(u)
    present = fail_safe.present(readings)
    belief, trust = _sensed(belief, fail_safe.at_start(readings), readings, present, p, 0.0)
    some = fail_safe.in_use(trust, present, p)
    smoothed = smoothing.begun(where(some > 0, grown(belief, p), 0.0))
    states = _named(belief, trust, 0.0, smoothed, readings, p)
    return {**states, **leaps.none(readings), "wild": 0.0, "waited": 0.0}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample."""
    readings = sensed(u)
    before = fail_safe.trust_of(x)
    news, trust = fail_safe.fresh(before, readings, p, step)
    belief, trust = _sensed(_later(x.estimate, x.spread, p, step), trust, readings, news, p, step)
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


def _sensed(
    belief: Estimate, trust: fail_safe.Trust, readings: Number, news: Number, p: Record, step: Number
) -> tuple[Estimate, fail_safe.Trust]:
    """Estimate of temperatures in K above their means, and trust, after the readings."""
    rises = readings - p.reference_temperature - p.mean_rise
    return sense(belief, trust, lambda i: placed(1.0, i, SENSORS), rises, news, p, step)


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
