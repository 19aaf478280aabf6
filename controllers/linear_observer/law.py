"""Growth by a Kalman filter on a linear model of any machine, found from runs of its FMUs; see model.py.

    z' = Phi z + Psi B f + w,    w of covariance h W

W is how far the model was off in runs that it was not made from. Readings enter one after the other, so that
any can be left out; without them the model goes on by the duty alone. See README.md.
"""

from warmlink.controllers import fail_safe
from warmlink.controllers.estimate import Estimate, sense
from warmlink.controllers.interface import sensed
from warmlink.controllers.kalman import carried_over, variance_along
from warmlink.controllers.linear_observer import model
from warmlink.controllers.linear_observer.model import MODES, SENSORS, growth, sensor_row
from warmlink.controllers.matrices import dot, matrix
from warmlink.controllers.observer.model import (
    BelievedDuty,
    believed,
    believed_at_start,
    believed_states,
)
from warmlink.controllers.regression.law import LARGEST_GROWTH
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, finite, maximum, minimum, truth, where

COLD, NOISY = 1e-4, 3.0
"""Share of `start_spread` of a cold machine, and standard deviations of a reading that make none warm."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: what the first readings say, of a machine that is cold or was left warm."""
    readings, duty = sensed(u), believed_at_start(u, p)
    present = fail_safe.present(readings)
    belief = _at_start(readings, duty, p)
    belief, trust = _sensed(belief, fail_safe.at_start(readings), readings, present, p, 0.0)
    return {
        **_named(belief, trust, duty),
        "correction": 0.0,
        "elongation": growth(belief.mean, p),
        "distrusted": fail_safe.distrusted(trust, readings, p),
        "waited": 0.0,
    }


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample, during which the duty was as at the last one."""
    readings = sensed(u)
    duty, _, doubted = believed(x, u, p, step)
    before = BelievedDuty(x.believed_speed, x.believed_torque, x.believed_ambient)
    belief = Estimate(model.later(x.estimate, before, p), _spread_later(x, p))
    news, trust = fail_safe.fresh(fail_safe.trust_of(x), readings, p, step)
    belief, trust = _sensed(belief, trust, readings, news, p, step)
    sound = truth(absolute(growth(belief.mean, p)) <= LARGEST_GROWTH)
    unsure = Estimate(0.0 * belief.mean, p.start_spread)
    belief = Estimate(*(where(sound > 0, *each) for each in zip(belief, unsure, strict=True)))
    wanted = where(sound > 0, growth(belief.mean, p), x.correction)
    correction = fail_safe.limited(x.correction, wanted, p, step)
    waited = fail_safe.waited_on(x.waited, readings, p, step)
    unheard = fail_safe.distrusted(trust, readings, p)
    later = {
        **_named(belief, trust, duty),
        "correction": correction,
        "elongation": wanted,
        "distrusted": maximum(maximum(doubted, unheard), 1.0 - sound),
        "waited": waited,
    }
    again = fail_safe.begins_again(x.waited, x.trust_last, readings, p, step)
    kept = {"correction": correction, "waited": waited}
    return fail_safe.begun_again(begin, later, u, p, again) | kept


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m: the filter's, and what the model was off in runs not made from."""
    variance = variance_along(x.spread, p.growth_row) + p.model_std**2
    variance = variance + (p.relative_std * x.elongation) ** 2
    return fail_safe.reported(x, variance**0.5, p, x.distrusted)


@as_c_function
def _at_start(readings: Number, duty: BelievedDuty, p: Record) -> Estimate:
    """What is known before the first readings are taken in: as unsure as they are far from a cold machine."""
    cold = p.even_profile * (duty.ambient_temperature - p.reference_temperature)
    far: Number = COLD
    for i in range(SENSORS):
        row = sensor_row(i, p)
        expected = variance_along(p.start_spread, row) + p.sensor_std[i] ** 2 + 1e-9
        off = readings[i] - p.sensor_reference[i] - dot(row, cold)
        share = where(finite(off), (off**2 - (NOISY * p.sensor_std[i]) ** 2) / expected, 1.0)
        far = maximum(far, where(p.sensor_std[i] > 0, share, 0.0))
    return Estimate(cold, minimum(far, 1.0) * p.start_spread)


def _spread_later(x: Record, p: Record) -> Number:
    return carried_over(x.spread, matrix(p.carried, MODES)) + p.sample_time * p.noise


def _sensed(
    belief: Estimate, trust: fail_safe.Trust, readings: Number, news: Number, p: Record, step: Number
) -> tuple[Estimate, fail_safe.Trust]:
    """Estimate and trust after the readings."""
    rises = readings - p.sensor_reference
    return sense(belief, trust, lambda i: sensor_row(i, p), rises, news, p, step)


def _named(belief: Estimate, trust: fail_safe.Trust, duty: BelievedDuty) -> dict[str, Number]:
    named = {"estimate": belief.mean, "spread": belief.spread}
    return {**named, **fail_safe.trust_named(trust), **believed_states(duty)}
