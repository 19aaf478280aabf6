"""What each group of signals says by itself, and how far the correction may go where groups disagree.

Three witnesses of the elongation: the filter, the duty alone, and the thermometers alone. Any one of them may
be wrong. A correction between nothing and what a witness says can not be worse than no correction if that
witness is right. So where the witnesses disagree, the correction keeps within what each of them allows.
README.md has the equations and the reasons.
"""

from typing import NamedTuple

from warmlink.controllers.interface import SIGMAS
from warmlink.controllers.observer.filters import Filters
from warmlink.controllers.observer.model import MODES, SENSORS, WINDING, BelievedDuty, elongation
from warmlink.controllers.observer.readings import Compared, Shape, cools, extremes, shape_of
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Record, State
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    finite,
    maximum,
    minimum,
    placed,
    stack,
    total,
    truth,
    where,
)

STATES = (
    State("seen", "K", size=SENSORS),
    State("lagged", "K", size=SENSORS),
    State("known_for", "s"),
    State("agreed_for", "s"),
    State("waited", "s"),
    State("doubt", "1"),
)
"""Readings without their noise, and since when all agree."""

KNOWN_TIME, AGREEMENT_TIME = 60.0, 600.0
"""s for which all must agree after a start, and after a disagreement."""

COLD_TIME = 10.0
"""s for which readings must be as foreseen after a cold start, as soon a pad would make them differ, and for
which they must look like a cell that was left warm before the correction begins to follow them."""

SHOWN_TIME = 50.0
"""s for which they must do so until the correction may go all the way."""

WARM_TIME = 240.0
"""s after a start in which readings may show that the cell was left warm: later it warms itself."""

MARGIN, LEARNT_MARGIN = 0.5, 2.0
"""Tolerances by which a witness may be off, and how many more at most if a log showed that the duty's is:
then thermometers know better than the model, which may be of another structure."""

DUTY_SHARE, UNSURE_SHARE, SENSED_SHARE = 0.6, 0.25, 0.25
"""Share by which the elongation may exceed what the duty tells, the same while a thermometer is left out or
it is unknown how warm the cell is, and what the thermometers tell."""


def first_states(readings: Number, duty: BelievedDuty, known: Number) -> dict[str, Number]:
    """The states at the start: whether it is known how warm the cell is, and nothing contradicts it."""
    surroundings = stack(*[duty.ambient_temperature] * SENSORS)
    return {
        "seen": where(finite(readings), readings, surroundings),
        "lagged": 0.0 * surroundings,
        "known_for": KNOWN_TIME * known,
        "agreed_for": AGREEMENT_TIME,
        "waited": WARM_TIME * known,
        "doubt": 1.0,
    }


class Look(NamedTuple):
    """What a camera says.

    Attributes
    ----------
    elongation : in m
    there : 1 where it says anything
    denies : by how much in m that was beyond what the filter made of the temperatures then
    """

    elongation: Number = 0.0
    there: Number = 0.0
    denies: Number = 0.0


class Verdict(NamedTuple):
    """How far the correction may go, and what is remembered.

    Attributes
    ----------
    lower, upper : bounds in m on the correction
    known_for, agreed_for : time in s for which all has agreed since the start, and since a disagreement
    duty_modes : the modes by the duty alone, from which it goes on
    doubt : 1 where the witnesses do not bear the correction out, so that it is not ready
    disagree : 1 where they contradict each other
    alike : as in `Shape`
    warm : 1 where readings have just shown that the cell was left warm
    """

    lower: Number
    upper: Number
    known_for: Number
    agreed_for: Number
    duty_modes: Number
    doubt: Number
    disagree: Number
    alike: Number
    warm: Number


class Known(NamedTuple):
    """Time in s for which all has agreed; 1 where readings have just shown that the cell was left warm."""

    known_for: Number
    warm: Number


def heard(
    x: Record,
    filters: Filters,
    estimate: Number,
    duty_modes: Number,
    sensors: Compared,
    p: Record,
    step: Number,
    camera: Look,
) -> Verdict:
    """Hear the witnesses.

    Parameters
    ----------
    filters : of which the alert one may be followed
    estimate : elongation in m by the filter
    duty_modes : the modes by duty and surroundings alone
    camera : a fourth witness
    """
    already = truth(x.known_for >= KNOWN_TIME)
    early = truth(x.waited < WARM_TIME)
    shape = shape_of(sensors, already, early, x.heated, p)
    # Only what the first readings showed can be left of another shift: heat that flows soon looks like it.
    warm = truth(x.known_for > x.waited - COLD_TIME) * cools(sensors, p)
    known = _known(Known(x.known_for, 0.0), sensors, warm, p, step, 1.0 - already)
    return _weighed(x, filters, estimate, duty_modes, sensors, shape, known, p, step, camera)


@skip_if_zero
def _known(before: Known, sensors: Compared, warm: Number, p: Record, step: Number, unknown: Number) -> Known:
    """After a start: all is as foreseen, or the cell was left warm; without thermometers, hours pass."""
    used = truth(p.sensor_std > 0)
    some = truth(total(used) > 0)
    excess, rise, whole = sensors.excess, sensors.rise, sensors.whole
    # What all of them are off by matters where it makes more growth than the tolerance.
    slight = maximum(2.5 * p.sensor_std, p.tolerance / p.elongation_per_kelvin)
    far = where(absolute(excess) > slight + 0.05 * absolute(rise), used, 0.0)
    near = whole * where(total(far) > 0, 0.0, 1.0)
    left_warm = whole * where(sensors.least > 0, 1.0 - near, 0.0) * warm
    pace = where(near > 0, KNOWN_TIME / COLD_TIME, left_warm)
    pace = where(some > 0, pace, KNOWN_TIME * absolute(p.mode_rate[0]) / 3.0)
    known_for = maximum(before.known_for + where(pace > 0, pace, -1.0) * step, 0.0)
    warm = where(known_for >= KNOWN_TIME, left_warm, 0.0)
    return Known(where(unknown > 0, known_for, before.known_for), unknown * warm)


@as_c_function
def _weighed(
    x: Record,
    filters: Filters,
    estimate: Number,
    duty_modes: Number,
    sensors: Compared,
    shape: Shape,
    after: Known,
    p: Record,
    step: Number,
    camera: Look,
) -> Verdict:
    """The verdict from all that the witnesses say."""
    called, excess = sensors.called, sensors.excess
    by_duty = elongation(duty_modes, p)
    used = truth(p.sensor_std > 0)
    count = total(called)
    every = truth(total(used) - count < 0.5)
    by_one = total(p.growth_by_one * called * excess) / maximum(count, 1.0)
    sensed = by_duty + where(every > 0, total(p.growth_by_all * excess), by_one)
    known = truth(after.known_for >= KNOWN_TIME)
    # The longer readings look like a cell left warm, the further the duty's bound follows: nothing leaps.
    shown = clip((after.known_for - COLD_TIME) / (SHOWN_TIME - COLD_TIME), 0.0, 1.0)
    told = by_duty + where(x.known_for < KNOWN_TIME, shown, 0.0) * (estimate - by_duty)

    # Heat that no input tells of is believed where it looks like heat: from the shaft outwards.
    margin = MARGIN * p.tolerance + minimum(SIGMAS * p.duty_std, LEARNT_MARGIN * p.tolerance)
    only_one = truth(total(used) < 1.5)
    heat = known * maximum(only_one, where(count > 1.5, shape.falls, 0.0))
    unsure = total(sensors.there - sensors.trusted) + 1.0 - known
    low_d, high_d = _allowed(told, where(unsure > 0, UNSURE_SHARE, DUTY_SHARE), margin)
    # Until it is known how warm the cell is, no thermometer outvotes another; the winding's tells least.
    winding = placed(1.0, WINDING, SENSORS)
    others = sensors.there * (1.0 - winding)
    alone = where(total(others) > 0, others, sensors.there)
    largest, least = extremes(by_duty + p.growth_by_one * excess, alone)
    low_s, _ = _allowed(where(known > 0, sensed, largest), SENSED_SHARE, margin)
    _, high_s = _allowed(where(known > 0, sensed, least), SENSED_SHARE, margin)
    lasting = where(x.agreed_for >= AGREEMENT_TIME, heat, 0.0)
    beyond_duty = where(count > 0, lasting, known)
    limit = p.correction_limit
    lower = maximum(low_d, where(count > 0, low_s, -limit))
    upper = minimum(where(beyond_duty > 0, limit, high_d), where(count > 0, high_s, limit))
    # Where duty and thermometers are apart, neither outvotes a camera that denies what the filter made.
    low_c, high_c = _allowed(camera.elongation, SENSED_SHARE, margin)
    denied = truth(absolute(camera.denies) > margin + SENSED_SHARE * absolute(camera.elongation))
    most = maximum(absolute(by_duty), absolute(sensed))
    third = where(absolute(by_duty - sensed) > margin + SENSED_SHARE * most, denied * camera.there, 0.0)
    lower = where(third > 0, maximum(lower, low_c), lower)
    upper = where(third > 0, minimum(upper, high_c), upper)
    # Where they disagree, the camera is followed as far as duty or thermometers bear it out.
    apart = [absolute(camera.elongation - each) - SENSED_SHARE * absolute(each) for each in (by_duty, sensed)]
    second = where(minimum(apart[0], where(count > 0, apart[1], limit)) < margin, camera.there, 0.0)
    second = where(x.agreed_for < AGREEMENT_TIME, second, 0.0)
    lower, upper = (where(second > 0, camera.elongation, bound) for bound in (lower, upper))

    outside = where(estimate > high_d, 1.0 - heat, 0.0)
    short = truth(absolute(estimate) < absolute(by_duty) / (1.0 + DUTY_SHARE) ** 1.5 - margin)
    astray = truth(absolute(estimate - sensed) > margin + SENSED_SHARE * absolute(sensed))
    astray = where(count > 0, astray, 0.0)
    warm = after.warm
    disagree = (1.0 - warm) * maximum(maximum(outside, short), astray)
    agreed_for = minimum(x.agreed_for + step, 10.0 * AGREEMENT_TIME)
    agreed_for = where(disagree > 0, 0.0, where(warm > 0, AGREEMENT_TIME, agreed_for))
    doubt = maximum(1.0 - known, truth(agreed_for < AGREEMENT_TIME))
    duty_modes = where(warm > 0, filters.alert.mean[:MODES], duty_modes)
    return Verdict(lower, upper, after.known_for, agreed_for, duty_modes, doubt, disagree, shape.alike, warm)


def _allowed(witness: Number, share: Number, margin: Number) -> tuple[Number, Number]:
    """Corrections in m that are no worse than none if a witness is right, within a share of what it says."""
    told = (1.0 + share) * witness
    return minimum(told, 0.0) - margin, maximum(told, 0.0) + margin
