"""What the duty alone says of sensors that contradict each other, and of the least elongation."""

from __future__ import annotations

from warmlink.controllers import fail_safe
from warmlink.controllers.kalman import Belief
from warmlink.controllers.observer.model import (
    HEATS,
    MODES,
    SENSORS,
    STATES,
    elongation,
    losses,
    temperature,
)
from warmlink.fmus.arithmetic import Number, absolute, exp, finite, maximum, stack, total, where
from warmlink.fmus.packaging.component import Record

LEAST_SHARE = 0.5
"""Share of the elongation by duty alone that unknown heat and a wrong model leave at least."""


def reconciled(
    belief: Belief,
    trust: fail_safe.Trust,
    readings: Number,
    duty_modes: Number,
    plausible: Number,
    u: Record,
    p: Record,
) -> tuple[Belief, fail_safe.Trust]:
    """Belief and trust once sensors that contradict each other are settled.

    A sensor that drifts away slowly has no telling innovation: the filter makes up heat that explains it.
    Such heat soon exceeds what a wrong model may account for. Then the sensor that is farthest from what the
    duty alone makes of its temperature is left out, and the made-up heat is forgotten.
    """
    in_link = belief.mean[MODES + 1]
    noise = belief.noise_spread[MODES + 1, MODES + 1] ** 0.5
    too_much = absolute(in_link) - 4.0 * noise > plausible

    farthest: Number = 0.0
    strangeness = []
    for i in range(SENSORS):
        expected = temperature(i, duty_modes, p)
        allowed = 3.0 * p.sensor_std[i] + p.model_share * absolute(expected - u.ambient_temperature)
        strange = absolute(readings[i] - expected) / maximum(allowed, 1e-3)
        candidate = where(p.sensor_std[i] > 0, 1.0 - trust.out[i], 0.0)
        strangeness.append(where(candidate > 0, where(finite(strange), strange, 0.0), 0.0))
        farthest = maximum(farthest, strangeness[i])
    out = stack(
        *(
            where(too_much, where(strangeness[i] >= farthest, where(farthest > 0, 1.0, 0.0), 0.0), 0.0)
            for i in range(SENSORS)
        )
    )
    keep = stack(
        *[1.0] * (MODES), *[where(too_much, 0.0, 1.0)] * HEATS, *[1.0] * (belief.mean.shape[0] - STATES)
    )
    return belief._replace(mean=keep * belief.mean), trust._replace(
        out=where(out > 0, 1.0, trust.out), calm_for=where(out > 0, 0.0, trust.calm_for)
    )


def plausible_link_heat(before: Number, mean: Number, u: Record, p: Record, step: Number) -> Number:
    """Unknown heat in W in the link that a wrong model may explain: shares of what it loses and receives.

    Once plausible, it fades no faster than the unknown heat itself.
    """
    modes, in_shaft = mean[:MODES], mean[MODES]
    rise = total(p.elongation_row * modes) / p.elongation_per_kelvin
    surroundings = u.ambient_temperature - p.linearisation_temperature
    conductance = p.link_loss + absolute(u.speed) * p.link_loss_per_speed
    winding_loss, shaft_loss = losses(modes, u, p)
    received = winding_loss + shaft_loss + absolute(in_shaft)
    now = p.model_share * conductance * absolute(rise - surroundings) + p.received_share * received
    return maximum(now, before * exp(-step / p.disturbance_time[1]))


def least_elongation(duty_modes: Number, u: Record, p: Record) -> Number:
    """Elongation in m that there is at least: unknown heat warms, it hardly cools.

    Half of what the duty makes beyond that of the surroundings, less half the tolerance.
    """
    by_surroundings = p.elongation_per_kelvin * (u.ambient_temperature - p.reference_temperature)
    beyond = elongation(duty_modes, p) - by_surroundings
    return elongation(duty_modes, p) - (1.0 - LEAST_SHARE) * absolute(beyond) - LEAST_SHARE * p.tolerance
