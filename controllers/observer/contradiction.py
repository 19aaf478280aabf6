"""What the duty alone says of sensors that contradict each other."""

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.kalman import Belief, either
from warmlink.controllers.matrices import blocks, diagonal, outer, symmetric, upper, upper_diagonal
from warmlink.controllers.observer.filters import Filters, together
from warmlink.controllers.observer.model import (
    HEATS,
    MODES,
    SENSORS,
    STATES,
    BelievedDuty,
    losses,
    temperatures,
)
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total, truth, where

WILD = 2000.0
"""K; modes whose sizes add up to more are no estimate."""


class Examined(NamedTuple):
    """What shows that estimates cannot be right.

    Attributes
    ----------
    wild : 1 where an estimate is none, so that all begins again
    duty_modes : the modes by the duty alone, cold if they are none
    expected : the sensors' temperatures in K that follow from these
    own_heat : losses of the motor in W
    plausible : unknown heat in W in the link that a wrong model may explain
    too_much : 1 where there seems to be more
    """

    wild: Number
    duty_modes: Number
    expected: Number
    own_heat: Number
    plausible: Number
    too_much: Number


@as_c_function
def examined(filters: Filters, duty_modes: Number, before: Number, duty: BelievedDuty, p: Record) -> Examined:
    """Examine what the filters and the duty say; `before` is the heat that was plausible."""
    lost = where(total(absolute(duty_modes)) <= WILD, 0.0, 1.0)
    cold = p.uniform_profile * (duty.ambient_temperature - p.linearisation_temperature)
    wild = lost
    alert = filters.alert
    for each in (alert, filters.quiet):
        wild = maximum(wild, where(total(absolute(each.mean[:MODES])) <= WILD, 0.0, 1.0))
    winding_loss, shaft_loss = losses(alert.mean[:MODES], duty, p)
    own_heat = winding_loss + shaft_loss
    plausible = _plausible_link_heat(before, alert.mean, own_heat, duty, p)
    variances = upper_diagonal(alert.noise_spread, alert.mean.shape[0])
    noise = maximum(variances[MODES + 1], 0.0) ** 0.5
    too_much = truth(absolute(alert.mean[MODES + 1]) - 4.0 * noise > plausible)
    duty_modes = where(lost > 0, cold, duty_modes)
    return Examined(wild, duty_modes, temperatures(duty_modes, p), own_heat, plausible, too_much)


def reconciled(
    filters: Filters, trust: fail_safe.Trust, readings: Number, what: Examined, u: Record, p: Record
) -> tuple[Filters, fail_safe.Trust, Number]:
    """Filters and trust after contradicting sensors are left out; 1 where the alert filter begins again.

    A sensor that drifts away slowly shows no large innovation, because the filter explains it by unknown
    heat. Such heat soon exceeds what a wrong model can explain. Then the sensor that is farthest from the
    temperature that follows from the duty alone is left out, and so is every other sensor that contradicts
    the duty: with a heating pad on, it is impossible to know which sensor is right. The estimate begins
    again from the duty. It also does so where it is not a possible state.
    """
    begins = maximum(what.too_much, what.wild)
    before = trust.out, trust.calm_for, 0.0
    out, calm_for, warmth = _left_out(before, readings, what, u, p, begins)
    trust = trust._replace(out=out, calm_for=calm_for)
    return _begun_again(filters, what.duty_modes, warmth, p, begins), trust, begins


@skip_if_zero
def _left_out(
    before: tuple[Number, Number, Number],
    readings: Number,
    what: Examined,
    u: Record,
    p: Record,
    begins: Number,
) -> tuple[Number, Number, Number]:
    """Which sensors are left out, how long they have been calm, and how warm in K the cell may be."""
    already, calm_for, warmth = before
    deviation, strangeness = [], []
    farthest: Number = 0.0
    for i in range(SENSORS):
        expected = what.expected[i]
        candidate = where(p.sensor_std[i] > 0, (1.0 - already[i]) * fail_safe.present(readings[i]), 0.0)
        deviation.append(where(candidate > 0, absolute(readings[i] - expected), 0.0))
        allowed = 3.0 * p.sensor_std[i] + p.model_share * absolute(expected - u.ambient_temperature)
        strangeness.append(deviation[i] / maximum(allowed, 1e-3))
        farthest = maximum(farthest, strangeness[i])
    left_out = []
    for i in range(SENSORS):
        farthest_here = where(strangeness[i] >= farthest, truth(farthest > 0), 0.0)
        strange = where(strangeness[i] > 1.0, 1.0, farthest_here)
        left_out.append(what.too_much * strange)
        warmth = maximum(warmth, deviation[i])
    out = stack(*left_out)
    return where(out > 0, 1.0, already), where(out > 0, 0.0, calm_for), begins * warmth


@skip_if_zero
def _begun_again(filters: Filters, duty_modes: Number, warmth: Number, p: Record, begins: Number) -> Filters:
    """The alert filter from the duty alone, without unknown heat, as uncertain in K as the sensors suggest.

    What was learnt from a camera is kept.
    """
    belief = filters.alert
    taught = belief.mean.shape[0] - STATES
    doubt = (
        symmetric(p.warm_spread, MODES) * warmth**2
        + outer(p.uniform_profile, p.uniform_profile) * p.initial_std**2
        + diagonal(p.profile_std**2)
    )
    zero = [0.0] * HEATS
    nothing = outer(p.uniform_profile, belief.mean[MODES:]) * 0.0
    kept = [upper_diagonal(each, STATES + taught)[STATES:] for each in (belief.spread, belief.noise_spread)]
    heats = p.disturbance_std[:HEATS] ** 2
    mean = stack(duty_modes, *zero, *([belief.mean[STATES:]] if taught else []))
    again = Belief(
        mean,
        upper(blocks(doubt, nothing, diagonal(stack(heats, *([kept[0]] if taught else []))))),
        upper(blocks(doubt, nothing, diagonal(stack(*zero, *([kept[1]] if taught else []))))),
    )
    return together(either(begins, again, belief), filters.quiet)


def _plausible_link_heat(before: Number, mean: Number, own_heat: Number, u: Record, p: Record) -> Number:
    """Unknown heat in W in the link that a wrong model may explain: shares of what it loses and receives.

    Once plausible, it fades no faster than the unknown heat itself.
    """
    modes, in_shaft = mean[:MODES], mean[MODES]
    rise = total(p.elongation_row * modes) / p.elongation_per_kelvin
    surroundings = u.ambient_temperature - p.linearisation_temperature
    conductance = p.link_loss + absolute(u.speed) * p.link_loss_per_speed
    received = own_heat + absolute(in_shaft)
    now = p.model_share * conductance * absolute(rise - surroundings) + p.received_share * received
    return maximum(now, before * p.fade[1])
