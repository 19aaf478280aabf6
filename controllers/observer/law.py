"""Elongation from a Kalman filter on a few modes of motor and link.

    dz/dt = (the reduced model of `model.py`) + B_s d_1 + B_l d_2

d_1 and d_2 are heat in W that no input tells of, into the shaft (a pad, say) and into the link, each with
exponentially fading correlation. Two filters expect more and less of it, see `filters.py`. Readings enter one
after the other, so any may be left out. See README.md.
"""

from __future__ import annotations

from collections.abc import Mapping

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SENSED
from warmlink.controllers.kalman import Belief, carried, corrected, variance_along
from warmlink.controllers.matrices import blocks, diagonal, diagonal_of, matrix, outer, symmetric
from warmlink.controllers.observer.contradiction import least_elongation, plausible_link_heat, reconciled
from warmlink.controllers.observer.filters import (
    EVIDENCE_SIGMAS,
    Filters,
    allowed_for,
    filters_named,
    filters_of,
    led,
    quieted,
)
from warmlink.controllers.observer.model import (
    HEATS,
    MODES,
    SENSORS,
    STATES,
    by_duty,
    decay_and_reach,
    elongation,
    known_heat,
    sensor_row,
    temperature,
)
from warmlink.controllers.verdict import ready
from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import (
    Number,
    absolute,
    clip,
    exp,
    finite,
    maximum,
    minimum,
    placed,
    stack,
    total,
    where,
)

HEAT = slice(0, HEATS)
"""Which of the disturbances are unknown heat."""

LARGEST_EVIDENCE = 4.0
"""Bound on the squared ratio of disturbances seen to disturbances designed for."""


def begin(u: Record, p: Record) -> Mapping[str, Number]:
    """States at the start: in equilibrium with the surroundings, or as warm as the first readings say."""
    start, readings = first_filters(u, p, STATES), sensed(u)
    trust = fail_safe.at_start(readings)
    filters, trust = sense(start, trust, readings, fail_safe.present(readings), 0.0, p, 0.0)
    return {
        **named(filters, trust, 0.0),
        "duty_modes": filters.alert.mean[:MODES],
        "plausible_heat": 0.0,
        "correction": 0.0,
        "elongation": elongation(filters.quiet.mean, p),
        "distrusted": distrusted(trust, readings, p),
    }


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Mapping[str, Number]:
    """States after a sample: carried over by the model, corrected by the readings, limited."""
    filters = predict(filters_of(x, STATES), u, p, step)
    readings = sensed(u)
    news, trust = fail_safe.fresh(fail_safe.trust_of(x), readings, p, step)
    filters, trust = sense(filters, trust, readings, news, x.evidence, p, step)
    duty_modes = by_duty(x.duty_modes, u, p, step)
    plausible = plausible_link_heat(x.plausible_heat, filters.alert.mean, u, p, step)
    alert, trust, again = reconciled(filters.alert, trust, readings, duty_modes, plausible, u, p)
    seen = evidence(x.evidence, alert, HEAT, p, since_heard(trust, readings, p, step))
    filters = led(Filters(alert, filters.quiet), seen, again, p)
    wanted = elongation(filters.quiet.mean, p)
    least = least_elongation(duty_modes, u, p)
    correction = fail_safe.limited(x.correction, maximum(wanted, least), p, step)
    return {
        **named(filters, trust, seen),
        "duty_modes": duty_modes,
        "plausible_heat": plausible,
        "correction": correction,
        "elongation": maximum(wanted, least),
        "distrusted": maximum(distrusted(trust, readings, p), where(wanted < least, 1.0, 0.0)),
    }


def outputs(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Correction and its uncertainty in m."""
    row = stack(p.elongation_row, *[0.0] * HEATS)
    return reported(x, filters_of(x, STATES), row, p)


def sensed(u: Record) -> Number:
    """Readings in K in the sensors' order, shape (5,); NaN where there is none."""
    return stack(*(getattr(u, name) for name in SENSED))


def named(filters: Filters, trust: fail_safe.Trust, seen: Number) -> dict[str, Number]:
    """What the filters remember, under the names of the law's states."""
    return {**filters_named(filters), "evidence": seen, **fail_safe.trust_named(trust)}


def first_filters(u: Record, p: Record, size: int) -> Filters:
    """Both filters before any reading."""
    start = first_belief(u, p, size)
    return Filters(start, quieted(start, p))


def first_belief(u: Record, p: Record, size: int) -> Belief:
    """Belief before any reading.

    Everything is at the surroundings' temperature. How sure that is, the readings tell: by how much the
    farthest lies beyond its noise is how warm the cell may be, with profiles that heat in the shaft leaves.
    """
    start = where(p.initial_temperature > 0, p.initial_temperature, u.ambient_temperature)
    warmth: Number = 0.0
    for name, std in zip(SENSED, [p.sensor_std[i] for i in range(SENSORS)], strict=True):
        beyond = absolute(getattr(u, name) - start) - 3.0 * std
        warmth = maximum(warmth, where(std > 0, where(finite(beyond), beyond, 0.0), 0.0))
    uniform = outer(p.uniform_profile, p.uniform_profile) * p.initial_std**2
    profile = diagonal(p.profile_std**2)
    warm = symmetric(p.warm_spread, MODES) * warmth**2
    rest = stack(*[0.0] * (size - MODES))
    doubt = diagonal(p.disturbance_std**2 * p.disturbance_start)
    none = outer(p.uniform_profile, rest) * 0.0
    mean = stack(p.uniform_profile * (start - p.linearisation_temperature), rest)
    return Belief(
        mean,
        blocks(uniform + warm + profile, none, doubt),
        blocks(uniform + warm, none, 0.0 * doubt),
    )


def predict(filters: Filters, u: Record, p: Record, step: Number) -> Filters:
    """Beliefs a step later: modes driven by losses, ambient and unknown heat, inputs held over the step."""
    decay, reach = decay_and_reach(p, step)
    fade = exp(-step / p.disturbance_time)
    extra = fade.shape[0] - HEATS
    by_heat = outer(reach * p.shaft_heat_gain, placed(1.0, 0, HEATS + extra)) + outer(
        reach * p.link_heat_gain, placed(1.0, 1, HEATS + extra)
    )
    # Of convection's effect on errors the diagonal is kept: the rest is a hundredth of it.
    own = decay + reach * absolute(u.speed) * diagonal_of(matrix(p.convection, MODES))
    transition = blocks(diagonal(own), by_heat, diagonal(fade))
    designed = stack(p.profile_std**2 * (1.0 - decay**2), p.disturbance_std**2 * (1.0 - fade**2))

    def later(belief: Belief, share: Number) -> Belief:
        modes, disturbances = belief.mean[:MODES], belief.mean[MODES:]
        unknown_heat = p.shaft_heat_gain * disturbances[0] + p.link_heat_gain * disturbances[1]
        drive = known_heat(modes, u, p) + unknown_heat
        mean = stack(decay * modes + reach * drive, fade * disturbances)
        return carried(belief, transition, mean, diagonal(allowed_for(designed, share)))

    return Filters(later(filters.alert, 1.0), later(filters.quiet, p.quiet_share))


def sense(
    filters: Filters,
    trust: fail_safe.Trust,
    readings: Number,
    news: Number,
    seen: Number,
    p: Record,
    step: Number,
) -> tuple[Filters, fail_safe.Trust]:
    """Beliefs and trust after the readings, taken one after the other; the alert filter judges them."""
    extra = filters.alert.mean.shape[0] - MODES
    gates = fail_safe.gates_of(p)
    means, calm, out = [], [], []
    for i in range(SENSORS):
        used = where(p.sensor_std[i] > 0, 1.0, 0.0)
        variance = where(used > 0, p.sensor_std[i] ** 2, 1.0)
        row = stack(sensor_row(i, p), *[0.0] * extra)
        innovations = Filters(*(readings[i] - temperature(i, each.mean[:MODES], p) for each in filters))
        widest = variance_along(filters.alert.spread, row)
        sure = variance_along(believed_spread(filters.alert, filters.alert, seen), row)
        news_here = used * news[i]
        verdict = fail_safe.judged(
            trust, i, news_here, innovations.alert, widest + variance, sure + variance, gates, step
        )
        filters = Filters(
            *(
                corrected(belief, row, innovation, variance, verdict.use)
                for belief, innovation in zip(filters, innovations, strict=True)
            )
        )
        means.append(verdict.mean)
        calm.append(verdict.calm_for)
        out.append(used * verdict.out)
    return filters, trust._replace(mean=stack(*means), calm_for=stack(*calm), out=stack(*out))


def evidence(before: Number, belief: Belief, of: slice, p: Record, elapsed: Number) -> Number:
    """How strong disturbances are seen to be: squared, relative to those designed for.

    An estimate within three standard deviations of what noise alone makes of it is none; a larger one is
    remembered while it fades.

    Parameters
    ----------
    before : the evidence so far
    of : which of the disturbances
    elapsed : time in s over which what is remembered fades
    """
    doubt = diagonal_of(belief.noise_spread)[MODES:][of]
    excess = (belief.mean[MODES:][of] ** 2 - EVIDENCE_SIGMAS**2 * doubt) / p.disturbance_std[of] ** 2
    seen: Number = before * exp(-elapsed / p.disturbance_time[0])
    for i in range(excess.shape[0]):
        seen = maximum(seen, excess[i])
    return clip(seen, 0.0, LARGEST_EVIDENCE)


def since_heard(trust: fail_safe.Trust, readings: Number, p: Record, step: Number) -> Number:
    """The step in s where a sensor is in use, else 0: nothing would show that an unknown heat has gone."""
    in_use = where(p.sensor_std > 0, fail_safe.present(readings) * (1.0 - trust.out), 0.0)
    return where(total(in_use) > 0, step, 0.0)


def believed_spread(belief: Belief, alert: Belief, seen: Number, taught: Number = 0.0) -> Number:
    """Covariance of a belief's error: its noise, and what disturbances as strong as they are seen to be add.

    What they add is counted as in the alert filter: by heat that is seen in temperatures and heats, by what a
    camera has taught in the elements after them, and by the weaker evidence of the two between them.
    """
    added = alert.spread - alert.noise_spread
    own = stack(*[1.0] * STATES, *[0.0] * (added.shape[0] - STATES))
    both = minimum(seen, taught)
    share = both + (seen - both) * outer(own, own) + (taught - both) * outer(1.0 - own, 1.0 - own)
    return belief.noise_spread + share * added


def reported(x: Record, filters: Filters, row: Number, p: Record, taught: Number = 0.0) -> dict[str, Number]:
    """The outputs, given the derivative of the elongation by the state and the evidence of a camera."""
    spread = believed_spread(filters.quiet, filters.alert, x.evidence, taught)
    variance = variance_along(spread, row)
    variance = variance + p.model_std**2 + (p.relative_std * x.elongation) ** 2
    std = fail_safe.with_held_back(variance**0.5, x)
    return {
        "correction": x.correction,
        "predicted_elongation": x.elongation,
        "correction_std": std,
        "ready": ready(std, p.tolerance),
        "distrusted": x.distrusted,
        "warning": fail_safe.warning(x.correction, x.elongation, p),
    }


def distrusted(trust: fail_safe.Trust, readings: Number, p: Record) -> Number:
    """1 where a signal that the law goes by is missing, or left out as not credible, else 0."""
    missing = 1.0 - fail_safe.present(readings)
    return where(total(where(p.sensor_std > 0, trust.out + missing, 0.0)) > 0, 1.0, 0.0)
