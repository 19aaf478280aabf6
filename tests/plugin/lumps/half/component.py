"""Growth in proportion to the temperature at the tip: correction = gain (T_tip - T_ambient)."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace

from warmlink.controllers.interface import compensator, error_parameters, error_std, law_outputs
from warmlink.fmus.component import Parameter, Record
from warmlink.fmus.component.arithmetic import Number, finite, where


def outputs(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
    """Correction in m; 0 while there is no reading."""
    rise = u.tip_temperature - u.ambient_temperature
    correction = where(finite(rise), p.gain * rise, 0.0)
    return law_outputs(correction, error_std(correction, p), p, distrusted=where(finite(rise), 0.0, 1.0))


COMPONENT = compensator(
    "HalfCompensator",
    "Growth in proportion to the temperature at the tip",
    SimpleNamespace(outputs=outputs),
    (
        Parameter("gain", "m/K", 8e-6, "growth per kelvin at the tip", display="um/K", nominal=8e-6),
        *error_parameters(5e-6),
    ),
)
