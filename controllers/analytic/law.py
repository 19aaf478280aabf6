"""Growth of a link from the temperature at its base and the time since it began to rise.

Eq. (4) of P. Poonyapak, M. J. D. Hayes and J. M. J. McDill, "Temperature-Induced Deformation in a Mechanical
System", as printed and corrected. Both take the base for a surface of a semi-infinite solid that stepped to
its present temperature when heating began.
"""

import math

from warmlink.controllers.fail_safe import FASTEST, FIRST_TIME, limited, reported
from warmlink.controllers.interface import error_std
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, erf, exp, finite, maximum, sqrt, truth, where
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE

PRINTED, CORRECTED = 0, 1
"""Values of the parameter `form`."""

BASE, SHAFT = 0, 1
"""Values of the parameter `temperature_source`."""

_EVER = 1e6
"""s for which a reading that is missing at the start may have been missing."""

_SHORTEST = 1e-9
"""s, in place of no time at all."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: the first good reading is where the link does not deform."""
    reading = measured(u, p)
    ambient = where(finite(u.ambient_temperature), u.ambient_temperature, ROOM_TEMPERATURE)
    first = where(finite(reading), reading, ambient)
    return {
        "reference": _reference(first, p),
        "warm": _left_warm(reading, u, p),
        "held": first,
        "waited": 0.0,
        "unheard_for": where(finite(reading), 0.0, _EVER),
        "heated_for": 0.0,
        "elongation": 0.0,
        "correction": 0.0,
        "distrusted": where(finite(reading), 0.0, 1.0),
    }


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample."""
    reading = measured(u, p)
    there = truth(finite(reading))
    # A reading does not leap, but may have gone anywhere while it was missing or not believed. Of one that
    # leaps soon after the start and the first one it is not known which is wrong: the later one is believed.
    leap = p.largest_leap + FASTEST * x.unheard_for
    near = where(absolute(reading - x.held) <= leap, there, 0.0)
    early = there * truth(x.waited < FIRST_TIME)
    good = maximum(near, early)
    temperature = where(good > 0, reading, x.held)
    reference = where(early * (1.0 - near) > 0, _reference(reading, p), x.reference)
    rise = temperature - reference
    heated_for = where(absolute(rise) < p.heating_rise, 0.0, x.heated_for + step)
    predicted = where(heated_for > 0, elongation(rise, heated_for, p), 0.0)
    return {
        "reference": reference,
        "warm": where(early * (1.0 - near) > 0, _left_warm(reading, u, p), x.warm),
        "held": temperature,
        "waited": x.waited + there * step,
        "unheard_for": where(good > 0, 0.0, x.unheard_for + step),
        "heated_for": heated_for,
        "elongation": predicted,
        "correction": limited(x.correction, predicted, p, step),
        "distrusted": 1.0 - good,
    }


def _reference(reading: Number, p: Record) -> Number:
    """Temperature in K at which the link does not deform, a reading where none is stated."""
    return where(p.reference_temperature > 0, p.reference_temperature, reading)


def _left_warm(reading: Number, u: Record, p: Record) -> Number:
    """1 if the link was warm at the first reading, so that its growth until then is unknown; else 0."""
    beyond = truth(absolute(reading - u.ambient_temperature) > p.largest_leap)
    return where(p.reference_temperature > 0, 0.0, beyond)


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m."""
    return reported(x, error_std(x.elongation, p), p, maximum(x.distrusted, x.warm))


def measured(u: Record, p: Record) -> Number:
    """The reading in K that the law goes by; may be NaN."""
    return where(p.temperature_source == SHAFT, u.shaft_temperature, u.base_temperature)


def elongation(rise: Number, time: Number, p: Record) -> Number:
    """Growth in m at a time in s after the base rose by so many K, in the form asked for."""
    diffusivity = p.conductivity / (p.density * p.specific_heat)
    depth = sqrt(diffusivity * maximum(time, _SHORTEST))
    length, expansion = p.heated_length, p.expansion_coefficient
    return where(
        p.form == PRINTED, printed(rise, depth, length, expansion), corrected(rise, depth, length, expansion)
    )


def printed(rise: Number, depth: Number, length: Number, expansion: Number) -> Number:
    """Eq. (4) as printed, in m: it falls with time, and takes cooling for heating.

    Parameters
    ----------
    rise : step of the base temperature in K
    depth : square root of diffusivity times time, in m
    length : length that expands, in m
    expansion : linear coefficient of thermal expansion in 1/K
    """
    return expansion * length * absolute(rise) * erf(length / depth)


def corrected(rise: Number, depth: Number, length: Number, expansion: Number) -> Number:
    """Integral in m over the length of the rise in a semi-infinite solid whose surface stepped.

        alpha dT [L erfc(L / 2 d) + 2 d / sqrt(pi) (1 - exp(-(L / 2 d)^2))],  d = sqrt(a t)

    The temperatures are those of J. P. Holman, *Heat Transfer*, 9th ed., McGraw-Hill 2002, section 4-3.
    Arguments as for `printed`.
    """
    reach = length / (2 * depth)
    far = length * (1 - erf(reach))
    near = 2 * depth / math.sqrt(math.pi) * (1 - exp(-(reach**2)))
    return expansion * rise * (far + near)
