"""What a model still gets wrong, as a weighted sum of slow first-order lags of what drives the machine.

d z_jk / dt = (f_j / scale_j - z_jk) / tau_k          from rest
remainder   = offset + gain own + sum of weight_jk z_jk     own: T_i - T_a of a temperature, the growth itself
f           = |w|, w^2, |w M|, M^2, I^2, P, T_a - T_ref, T_i - T_a

The remainder is what is measured less what the model says, so that it is added to the model's value. Lags
stand by time constant, then by feature (`lagged[k * FEATURES + j]`), weights by temperature, then by lag.
Nothing of it is fed back into the model, so that it is stable whatever the weights.
"""

from __future__ import annotations

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total

TEMPERATURES = 8
"""Temperatures of the model that are corrected, and whose lags are weighted."""

TIME_CONSTANTS = 3
"""Lags of each feature."""

FEATURES = 7 + TEMPERATURES
"""Functions f_j of the inputs that may go with an error."""

LAGS = FEATURES * TIME_CONSTANTS


def features(u: Record, p: Record) -> Number:
    """The functions f of the inputs as shares of their usual size, shape (FEATURES,)."""
    speed, mechanical = absolute(u.speed), absolute(u.speed * u.torque)
    drives = (speed, u.speed * u.speed, mechanical, u.torque * u.torque, u.current * u.current, u.power)
    room = u.ambient_temperature - p.reference_temperature
    rises = (u.temperature[i] - u.ambient_temperature for i in range(TEMPERATURES))
    return stack(*drives, room, *rises) / p.scale


def rates(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Time derivative of each lag in 1/s."""
    now = features(u, p)
    groups = (x.lagged[k * FEATURES : (k + 1) * FEATURES] for k in range(TIME_CONSTANTS))
    return {"lagged": stack(*((now - each) / p.time_constant[k] for k, each in enumerate(groups)))}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Corrected temperatures in K and elongation in m, how far outside what was learnt, and spreads."""
    remainders = (
        total(p.temperature_weight[i * LAGS : (i + 1) * LAGS] * x.lagged) for i in range(TEMPERATURES)
    )
    excess = maximum(x.lagged - p.largest, 0.0) + maximum(p.least - x.lagged, 0.0)
    outside = total(excess)
    scaled = p.temperature_gain * (u.temperature - u.ambient_temperature)
    grown = u.elongation * (1.0 + p.elongation_gain)
    return {
        "corrected_temperature": u.temperature + scaled + p.temperature_offset + stack(*remainders),
        "corrected_elongation": grown + p.elongation_offset + total(p.elongation_weight * x.lagged),
        "outside": outside,
        "temperature_spread": p.temperature_error * (1.0 + outside),
        "elongation_spread": p.elongation_error * (1.0 + outside),
    }
