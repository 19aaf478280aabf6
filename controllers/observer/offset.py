"""Tells offsets of thermometers from errors of the model, which are constant shares of the growth.

Where thermometers and duty differ, either the model is wrong or the thermometers are. Of a wrong model the
difference y of the growths, both in kelvins of an evenly warm link, follows the growth g that is known of:

    y = s g + s_1 L g + b + noise,        L g: g delayed by `DELAY`

s and s_1 are constant; b is an offset of the thermometers, and wanders. A Kalman filter of these three, with
the prior that the parameters state, tells them apart. It does so twice with the same gain: for the growth,
which shows what the thermometers have in common, and for the contrast of the innermost thermometer with the
outermost, which shows what one of them has alone. g is what lies above the surroundings; to it counts heat
from the shaft that no model's error explains, as a heating pad's.
b, or what s and s_1 leave of y where that is larger, is two standard deviations of the law's error, beside
the uncertainty of b. A machine of another structure than the model's has s and s_1 of its own: by their size,
growth counts that no thermometer shows.
"""

from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SIGMAS
from warmlink.controllers.matrices import diagonal, dot, matrix, outer, packed_size, symmetric, upper
from warmlink.controllers.observer.filters import Filters
from warmlink.controllers.observer.model import MODES, SENSORS, BelievedDuty, temperatures
from warmlink.controllers.observer.readings import Compared
from warmlink.controllers.observer.witnesses import Verdict
from warmlink.fmus.calls import as_c_function, skip_if_zero
from warmlink.fmus.component import Parameter, Record, State
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    finite,
    maximum,
    minimum,
    stack,
    total,
    truth,
    where,
)

DELAY = 1000.0
"""s of the first-order delay of what a wrong model gets wrong in time."""

SHARE, DELAYED_SHARE = 0.4, 0.05
"""Standard deviations of s and s_1: those of models whose thermal parameters are all off by up to 20 %."""

STRUCTURE = 20.0
"""K2.s, intensity of what two constants leave of a wrong model: 0.2 K that lasts for some minutes."""

HEAT_SHARE, HEAT_EXCESS = 0.6, 1.25
"""Unknown heat into the shaft that no model's error explains: what is beyond this share of the motor's
losses and this multiple of `disturbance_std`."""

LEFT = 0.5
"""K of growth by such heat below which it has gone."""

LATE = 20.0
"""s that such heat has flowed before it is noticed."""

OTHER = 0.2
"""Size of s and s_1, of growth and contrast, at which a machine surely has another structure than the model;
half of it counts a quarter."""

LOOK = 10.0
"""s between two updates of the filter."""

_OFFSET = "error that the thermometers may have in common at the start (1 sigma); affects only correction_std"
_WANDER = "by how much that error may wander in an hour (1 sigma); affects only correction_std"
PARAMETERS = (
    Parameter("offset_std", "K", 0.15, _OFFSET, minimum=0, nominal=0.1),
    Parameter("offset_per_hour", "K", 0.05, _WANDER, minimum=0, nominal=0.1),
)

STATES = (
    State("heat_modes", "1", size=MODES),
    State("heated", "1"),
    State("since", "s"),
    State("leapt", "K", size=SENSORS),
    State("delayed_growth", "K"),
    State("shares", "1", size=6),
    State("shares_spread", "1", size=packed_size(3)),
    State("unexplained", "K"),
)
"""Modes by unknown heat alone, 1 while there is any; time since the last update; by how much each thermometer
leapt there and back since one was left out, see `_remaining`; the fields of `Learnt`."""


KEPT = SENSORS + 1 + 6 + packed_size(3)
"""Numbers that `kept` gives."""


def kept(x: Record) -> Number:
    """What a restart must not forget: leaps of thermometers that are left out, and what has been learnt."""
    return stack(x.leapt, x.delayed_growth, x.shares, x.shares_spread)


def first_states(
    modes: Number,
    duty_modes: Number,
    recalled: Number,
    valid: Number,
    passed: Number,
    duty: BelievedDuty,
    p: Record,
) -> dict[str, Number]:
    """The states at the start, which go on with what was learnt before a restart.

    What the first readings show beyond that is an offset until it proves to be warmth.

    Parameters
    ----------
    modes, duty_modes : modes of the plant as the first readings show it, and as duty alone explains it
    recalled, valid, passed : what `kept` gave, shape (KEPT,); 1 where it did; and the time in s since then
    """
    leapt, delayed, shares = recalled[:SENSORS], recalled[SENSORS], recalled[SENSORS + 1 : SENSORS + 7]
    growth = _growth(duty_modes, p) - _cold(duty, p)
    toward = delayed + passed / (passed + DELAY) * (growth - delayed)
    delayed = where(valid > 0, toward, growth)
    beyond = _growth(modes - duty_modes, p) - dot(stack(growth, delayed, 1.0), shares[:3])
    doubt = beyond**2 + p.offset_per_hour**2 * passed / 3600.0
    spread = where(valid > 0, recalled[SENSORS + 7 :], _prior(p)) + upper(diagonal(stack(0.0, 0.0, doubt)))
    left = maximum(absolute(shares[2]), absolute(shares[5]))
    return {
        "heat_modes": 0.0 * duty_modes,
        "heated": 0.0,
        "since": 0.0,
        "leapt": leapt,
        "delayed_growth": delayed,
        "shares": shares,
        "shares_spread": spread,
        "unexplained": ((left / SIGMAS) ** 2 + maximum(spread[5], 0.0)) ** 0.5,
    }


def contradicted(x: Record) -> Number:
    """How far thermometers contradict the model's structure, squared: from 0 to 1."""
    shares = stack(x.shares[:2], x.shares[3:5])
    return minimum(dot(shares, shares) / OTHER**2, 1.0)


def compared(
    x: Record,
    filters: Filters,
    own_heat: Number,
    readings: Number,
    trust: fail_safe.Trust,
    sensors: Compared,
    verdict: Verdict,
    duty: BelievedDuty,
    p: Record,
    step: Number,
) -> dict[str, Number]:
    """The states after a sample; `own_heat` is the losses of the motor in W."""
    heat = filters.alert.mean[MODES]
    burst = truth(heat > HEAT_SHARE * own_heat + HEAT_EXCESS * p.disturbance_std[0])
    left = where(absolute(_growth(x.heat_modes, p)) > LEFT, x.heated, 0.0)
    heated = maximum(burst, left)
    heat_modes = where(x.heated > 0, x.heat_modes, LATE * heat * p.shaft_heat_gain)
    heat_modes = heated * _heated(heat_modes, heat, duty, p, heated)
    left_out = truth(total(trust.out) > 0)
    leap = trust.out * _leap(readings - x.trust_last, p, step)
    off = readings - temperatures(filters.quiet.mean[:MODES], p)
    leapt = left_out * _remaining(x.leapt, leap, off)
    brought = (1.0 - left_out) * total(_leap(x.leapt, p, 0.0) ** 2)
    since = x.since + step
    look = maximum(truth(since >= LOOK), maximum(verdict.warm, truth(brought > 0)))
    before = Learnt(*(getattr(x, name) for name in Learnt._fields))
    known = verdict.duty_modes + heat_modes
    shown = Shown(
        _growth(known, p) - _cold(duty, p),
        _growth(filters.quiet.mean[:MODES] - known, p),
        dot(p.contrast, sensors.seen) - dot(p.contrast_row, known),
        verdict.alike,
        sensors.whole * (1.0 - truth(total(leapt**2) > 0)),
        verdict.warm,
        brought,
    )
    learnt = _looked(before, shown, p, since, look)._asdict()
    since = where(look > 0, 0.0, since)
    return {"heat_modes": heat_modes, "heated": heated, "since": since, "leapt": leapt, **learnt}


@as_c_function
def _leap(change: Number, p: Record, step: Number) -> Number:
    """A change of readings in K, where neither noise nor heat makes as much in `step` seconds; else 0."""
    largest = 2.0**0.5 * p.gate * p.sensor_std + fail_safe.FASTEST * step
    return where(absolute(change) > largest, where(finite(change), change, 0.0), 0.0)


@as_c_function
def _remaining(before: Number, leap: Number, off: Number) -> Number:
    """What remains of all leaps in K: after a leap back, at most what a reading is then off by.

    The temperature has changed while the reading did not follow it.
    """
    after = before + leap
    back = truth(before * leap < 0)
    return where(back * truth(absolute(off) < absolute(after)) > 0, off, after)


class Learnt(NamedTuple):
    """States that change only with an update of the filter.

    Attributes
    ----------
    delayed_growth : L g in K
    shares : s, s_1 and b in K of the growth, then those of the contrast
    shares_spread : covariance of s, s_1 and b, packed
    unexplained : one standard deviation in K of what may be the law's error: by b, or by what s and s_1 leave
    """

    delayed_growth: Number
    shares: Number
    shares_spread: Number
    unexplained: Number


@skip_if_zero
def _heated(modes: Number, heat: Number, duty: BelievedDuty, p: Record, heated: Number) -> Number:
    """Modes a sample later by heat into the shaft alone."""
    drive = p.shaft_heat_gain * heat + absolute(duty.speed) * (matrix(p.convection, MODES) @ modes)
    later = p.decay * modes + p.reach * drive
    return where(heated > 0, later, modes)


class Shown(NamedTuple):
    """What an update of the filter goes by.

    Attributes
    ----------
    growth : g, in K as all of them
    difference : by how much the filter's growth is beyond what is known of
    contrast : the same of the innermost thermometer beside the outermost
    alike, warm : as in `witnesses.Verdict`
    whole : 1 where every thermometer in use is present, and none that leapt is left out, else 0
    brought : variance in K2 of the offset that thermometers bring which leapt, once all are used again
    """

    growth: Number
    difference: Number
    contrast: Number
    alike: Number
    whole: Number
    warm: Number
    brought: Number


@skip_if_zero
def _looked(before: Learnt, shown: Shown, p: Record, since: Number, look: Number) -> Learnt:
    """What is learnt by an update `since` seconds after the last one, where `look` is 1."""
    after = _learnt(before, shown, p, since)
    return Learnt(*(where(look > 0, new, old) for new, old in zip(after, before, strict=True)))


@as_c_function
def _learnt(before: Learnt, shown: Shown, p: Record, since: Number) -> Learnt:
    growth, warm = shown.growth, shown.warm
    delayed = before.delayed_growth + since / (since + DELAY) * (growth - before.delayed_growth)

    # Warmth that has just become known leaves nothing of what was learnt before.
    delayed = where(warm > 0, growth, delayed)
    shares = (1.0 - warm) * before.shares
    spread = symmetric(warm * _prior(p) + (1.0 - warm) * before.shares_spread, 3)
    wandered = p.offset_per_hour**2 * since / 3600.0
    spread = spread + diagonal(stack(0.0, 0.0, wandered + shown.brought))
    row = stack(growth, delayed, 1.0)
    across = spread @ row
    gain = across * (shown.whole / (dot(row, across) + STRUCTURE / since))
    learnt, left = [], shown.alike
    for of, y in ((shares[:3], shown.difference), (shares[3:], shown.contrast)):
        found = of + gain * (y - dot(row, of))
        rest = y - growth * found[0] - delayed * found[1]
        left = maximum(left, maximum(absolute(found[2]), absolute(rest)))
        learnt.append(found)
    spread = upper(spread - outer(gain, across))
    unexplained = ((left / SIGMAS) ** 2 + maximum(spread[5], 0.0)) ** 0.5  # rounding leaves less than 0
    return Learnt(delayed, stack(*learnt), spread, unexplained)


def _prior(p: Record) -> Number:
    """Covariance of s, s_1 and b before anything is learnt."""
    return upper(diagonal(stack(SHARE**2, DELAYED_SHARE**2, p.offset_std**2)))


def _growth(modes: Number, p: Record) -> Number:
    """Growth that modes make, in kelvins of an evenly warm link."""
    return dot(p.elongation_row, modes) / p.elongation_per_kelvin


def _cold(duty: BelievedDuty, p: Record) -> Number:
    """Growth in K of a link as warm as the surroundings."""
    return duty.ambient_temperature - p.linearisation_temperature
