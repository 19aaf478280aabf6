"""Elongation from a Kalman filter on a few modes of motor and link.

    dz/dt = (the reduced model of `model.py`) + B_s d_1 + B_l d_2

d_1 and d_2 are unknown heat in W, which is not among the inputs: into the shaft (from a heating pad, for
example) and into the link. Their correlation decays exponentially in time. Of two filters one expects more of
this heat and the other less, see `filters.py`. Readings enter one after the other, so that any can be left
out. See README.md.
"""

from collections.abc import Callable
from typing import NamedTuple

from warmlink.controllers import fail_safe, smoothing
from warmlink.controllers.interface import SIGMAS, SQUARE_MICROMETRE, sensed
from warmlink.controllers.kalman import variance_along
from warmlink.controllers.observer import offset, retained, witnesses
from warmlink.controllers.observer.contradiction import Examined, examined, reconciled
from warmlink.controllers.observer.filters import (
    Filters,
    believed_variance,
    evidence,
    filters_named,
    filters_of,
    led,
    quieted,
    sense,
    together,
)
from warmlink.controllers.observer.model import (
    HEATS,
    MODES,
    STATES,
    BelievedDuty,
    believed,
    believed_at_start,
    believed_states,
    by_duty,
    elongation,
    temperatures,
)
from warmlink.controllers.observer.prediction import predict
from warmlink.controllers.observer.readings import compared
from warmlink.fmus.calls import as_c_function
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    maximum,
    minimum,
    stack,
    total,
    truth,
    where,
)

STEADY = 0.04
"""Tolerances a second by which the correction changes at most, some time after a start: links grow slower."""

HEAT = (0, HEATS)
"""Places of the unknown heats among the disturbances: the first, and the one after the last."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: in equilibrium with the surroundings, or as warm as the first readings say."""
    return begun(u, p, STATES, elongation)


def begun(u: Record, p: Record, size: int, grown: Callable[[Number, Record], Number]) -> dict[str, Number]:
    """States of the observer after the first readings.

    Parameters
    ----------
    grown : elongation in m by the state of a filter, of `size` elements, and the parameters
    """
    duty, readings = believed_at_start(u, p), sensed(u)
    recalled = retained.recalled(duty, p)
    start = retained.first_belief(recalled, duty, readings, p, size)
    trust = fail_safe.at_start(readings)
    filters, trust = sense(
        together(start, quieted(start, p)), trust, readings, fail_safe.present(readings), 0.0, p, 0.0
    )
    duty_modes = where(recalled.valid > 0, recalled.duty_modes, start.mean[:MODES])
    # Where bounds held the correction back before a restart, they still do.
    held = recalled.valid * (1.0 - recalled.known)
    growth = where(held > 0, recalled.correction, grown(filters.quiet.mean, p))
    return {
        **named(filters, trust, 0.0),
        **believed_states(duty),
        **witnesses.first_states(readings, duty, recalled.known),
        **offset.first_states(
            filters.quiet.mean[:MODES],
            duty_modes,
            recalled.offsets,
            recalled.valid,
            recalled.passed,
            duty,
            p,
        ),
        "duty_modes": duty_modes,
        "plausible_heat": 0.0,
        "correction": recalled.correction,
        "elongation": growth,
        "smoothed": smoothing.begun(grown(filters.quiet.mean, p)),
        "distrusted": fail_safe.distrusted(trust, readings, p),
    }


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample: predicted by the model, corrected by the readings, and limited."""
    sample = sampled(x, u, p, step, STATES)
    seen = evidence(x.evidence, sample.filters, HEAT, p, sample.heard)
    filters = led(sample.filters, seen, sample.again, p)
    wanted, states = settled(x, sample, filters, elongation(filters.quiet.mean, p), p, step)
    later = {**named(filters, sample.trust, seen), **states, "elongation": wanted}
    return begun_again(begin, later, sample, x, u, p, step)


class Sample(NamedTuple):
    """Everything known after a sample's inputs were taken in, before the correction is computed.

    Attributes
    ----------
    duty : duty and surroundings as they are believed
    readings, trust, filters : as in the states that they become
    what : what the filters and the duty say
    again : 1 where the alert filter has begun again from the duty
    heard : 1 where a thermometer would show that a heat has come or gone, else 0
    doubted : 1 where duty or surroundings are not believed
    """

    duty: BelievedDuty
    readings: Number
    trust: fail_safe.Trust
    filters: Filters
    what: Examined
    again: Number
    heard: Number
    doubted: Number


def begun_again(
    begin: Callable[[Record, Record], Values],
    later: Values,
    sample: Sample,
    x: Record,
    u: Record,
    p: Record,
    step: Number,
) -> Values:
    """States after a sample; those of a start where a first reading was wrong, except the correction."""
    kept = {name: later[name] for name in ("correction", "waited")}
    again = fail_safe.begins_again(x.waited, x.trust_last, sample.readings, p, step)
    return fail_safe.begun_again(begin, later, u, p, again) | kept


def sampled(x: Record, u: Record, p: Record, step: Number, size: int) -> Sample:
    """Filters and memory after the inputs of a sample: duty, ambient temperature and thermometers."""
    duty, idle, doubted = believed(x, u, p, step)
    filters = predict(filters_of(x), duty, p)
    readings = sensed(u)
    news, trust = fail_safe.fresh(fail_safe.trust_of(x), readings, p, step)
    filters, trust = sense(filters, trust, readings, news, x.evidence, p, step)
    duty_modes = by_duty(x.duty_modes, idle, p)
    what = examined(filters, duty_modes, x.plausible_heat, duty, p)
    filters, trust, again = reconciled(filters, trust, readings, what, duty, p)
    heard = fail_safe.in_use(trust, news, p)
    return Sample(duty, readings, trust, filters, what, again, heard, doubted)


def settled(
    x: Record,
    sample: Sample,
    filters: Filters,
    estimate: Number,
    p: Record,
    step: Number,
    learnt: Number = 0.0,
    camera: witnesses.Look = witnesses.Look(),  # noqa: B008
) -> tuple[Number, dict[str, Number]]:
    """The elongation in m within the bounds that the witnesses confirm, and the states that follow from it.

    Parameters
    ----------
    estimate : elongation in m by the temperatures of the leading filter
    learnt : elongation in m that the camera adds to it
    """
    what, duty = sample.what, sample.duty
    # Thermometers are smoothed before bounds are set: a bound that opens for a hot cell makes no overshoot.
    smoothed = smoothing.smoothed(x.smoothed, where(what.wild > 0, x.smoothed[0], estimate), p, step)
    estimate = smoothing.on_time(smoothed)
    sensors = compared(x, what.expected, sample.readings, sample.trust, duty, p, step)
    verdict = witnesses.heard(x, filters, estimate, what.duty_modes, sensors, p, step, camera)
    borne_out = clip(estimate, verdict.lower, verdict.upper)
    # With the witnesses' margin of half a tolerance, a camera that lies as well stays below a whole one.
    more = minimum(absolute(learnt), 0.4 * p.tolerance)
    wanted = clip(estimate + learnt, verdict.lower - more, verdict.upper + more)
    wanted = where(what.wild > 0, x.correction, wanted)
    # After a start the correction has a long way to go; later no bound that comes or goes makes it leap.
    reach = where(x.waited < witnesses.WARM_TIME, p.correction_limit, STEADY * p.tolerance * step)
    wanted = x.elongation + clip(wanted - x.elongation, -reach, reach)
    suspected = offset.compared(
        x, filters, what.own_heat, sample.readings, sample.trust, sensors, verdict, duty, p, step
    )
    unheard = fail_safe.distrusted(sample.trust, sample.readings, p)
    doubted = maximum(maximum(sample.doubted, what.wild), maximum(unheard, verdict.disagree))
    unconfirmed = where(absolute(borne_out - estimate) > 1e-3 * p.tolerance, 1.0, verdict.doubt)
    silent = truth(total(p.sensor_std) > 0) * (1.0 - sample.heard)
    return wanted, {
        **believed_states(duty),
        "seen": sensors.seen,
        "lagged": sensors.lagged,
        "known_for": verdict.known_for,
        "agreed_for": verdict.agreed_for,
        "waited": fail_safe.waited_on(x.waited, sample.readings, p, step),
        **suspected,
        "doubt": where(what.wild > 0, 2.0, maximum(maximum(doubted, unconfirmed), silent)),
        "duty_modes": verdict.duty_modes,
        "plausible_heat": what.plausible,
        "smoothed": smoothed,
        "correction": fail_safe.limited(x.correction, wanted, p, step),
        "distrusted": doubted,
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m."""
    row, filters = stack(p.elongation_row, *[0.0] * HEATS), filters_of(x)
    return reported(x, filters, elongation(filters.quiet.mean, p), row, p)


def named(filters: Filters, trust: fail_safe.Trust, seen: Number) -> dict[str, Number]:
    """Name the filters' memory as the law's states are named."""
    return {**filters_named(filters), "evidence": seen, **fail_safe.trust_named(trust)}


def reported(
    x: Record,
    filters: Filters,
    estimate: Number,
    row: Number,
    p: Record,
    taught: Number = 0.0,
    watched: Number = 0.0,
    left: Number = 0.0,
) -> dict[str, Number]:
    """The outputs, from the filter's elongation, its derivative (`row`) and the camera's evidence.

    By how much a bound holds the correction off that elongation, it may be wrong.

    While a camera is followed (1) it shows what no thermometer does; else (0) that counts too. `left` is the
    error in m, beyond noise, that it last saw.
    """
    variance = believed_variance(filters.quiet, filters.alert, row, x.evidence, taught)
    variance = variance + p.model_std**2 + (estimate - x.elongation) ** 2
    variance = variance + (1.0 - watched) * _unseen(x, filters.quiet.mean, p) + (watched * left) ** 2
    reported = fail_safe.reported(x, variance**0.5, p, x.distrusted)
    return reported | {
        "retained": retained.kept(x, filters.quiet.mean),
        "ready": where(x.doubt > 0, 0.0, reported["ready"]),
        "warning": where(x.doubt > 1.5, 1.0, reported["warning"]),
    }


@as_c_function
def _unseen(x: Record, mean: Number, p: Record) -> Number:
    """Variance in m2 of the growth that thermometers in use do not show.

    What heat makes beyond the model counts as far as thermometers contradict the model, which they do on a
    machine of other structure. Of what the surroundings make no thermometer tells: that counts in full, as it
    does of a law that was learnt from a log. Where such a log showed that duty alone is off, so far an offset
    of thermometers is none.
    """
    measured = temperatures(mean[:MODES], p)
    around = x.believed_ambient - p.mean_temperature
    by_heat, by_room, learnt = (
        variance_along(p.coefficient_spread, each)
        for each in (measured - x.believed_ambient, around, measured - p.mean_temperature)
    )
    other = where(p.learnt > 0, learnt, offset.contradicted(x) * by_heat + by_room)
    off = maximum(p.elongation_per_kelvin * x.unexplained - SIGMAS * p.duty_std, 0.0)
    return SQUARE_MICROMETRE * other + off**2 + (p.relative_std * x.elongation) ** 2
