"""Closed forms that solvers are compared with: Eq. (4), its correction, solids, fins and bars.

Pure functions of floats or NumPy arrays, SI units. Eq. (4) and its correction are written in the analytic
law; here they take time and diffusivity.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
[2] H.S. Carslaw, J.C. Jaeger, Conduction of Heat in Solids, 2nd ed., Oxford 1959.
[3] F.P. Incropera, D.P. DeWitt, Fundamentals of Heat and Mass Transfer, chapter 3.6 (fins of uniform
section).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfc

from warmlink.controllers.analytic import law

Array = NDArray[np.float64]


def printed_eq4(time: ArrayLike, span: float, rise: float, expansion: float, diffusivity: float) -> Array:
    """Elongation [m] by Eq. (4) of [1] as printed, which shrinks with time; see the analytic law.

    Parameters
    ----------
    time : since the shaft's temperature rose [s], above 0, scalar or shape (n,)
    span : length L from shaft to diode [m]
    rise : |T_i - T_o| [K]
    expansion : coefficient of linear expansion [1/K]
    diffusivity : k / (rho c) [m2/s]
    """
    return np.asarray(law.printed(rise, _depth(time, diffusivity), span, expansion))


def halved_eq4(time: ArrayLike, span: float, rise: float, expansion: float, diffusivity: float) -> Array:
    """Elongation [m] by Eq. (4) of [1] with the factor 1/2 of Eq. (1); parameters as `printed_eq4`."""
    return printed_eq4(time, span / 2, rise, expansion, diffusivity) * 2


def corrected_eq4(time: ArrayLike, span: float, rise: float, expansion: float, diffusivity: float) -> Array:
    """Elongation [m] by Eq. (4) of [1] corrected, as the analytic law; parameters as `printed_eq4`.

    It is that of the stretch [0, L] of a semi-infinite solid whose surface is raised by dT at t = 0, the
    integral of alpha dT erfc(x / 2 sqrt(a t)) over the stretch ([2] chapter 2).
    """
    return np.asarray(law.corrected(rise, _depth(time, diffusivity), span, expansion))


def _depth(time: ArrayLike, diffusivity: float) -> Array:
    return np.sqrt(diffusivity * np.asarray(time, dtype=float))


def semi_infinite_rise(position: ArrayLike, time: ArrayLike, rise: float, diffusivity: float) -> Array:
    """Temperature rise [K] in a semi-infinite solid whose surface is raised by `rise` [K] at t = 0.

    dT erfc(x / 2 sqrt(a t)), [2] chapter 2; `position` [m], `time` [s] > 0, `diffusivity` [m2/s].
    """
    return np.asarray(rise * erfc(np.asarray(position, dtype=float) / (2 * _depth(time, diffusivity))))


def fin_parameter(convection: float, perimeter: float, conductivity: float, section: float) -> float:
    """Fin parameter m = sqrt(h P / (k A)) [1/m], [3]: h [W/(m2.K)], P [m], k [W/(m.K)], A [m2]."""
    return float(np.sqrt(convection * perimeter / (conductivity * section)))


def fin_rise(
    position: ArrayLike, length: float, root_rise: float, m: float, tip_biot_m: float = 0.0
) -> Array:
    """Steady temperature rise [K] along a fin, root held, tip losing heat, [3] table 3.4 case A.

    Parameters
    ----------
    position : distance from the root [m]
    length : of the fin [m]
    root_rise : root above ambient [K]
    m : fin parameter [1/m]
    tip_biot_m : h / (k m) at the tip face [1]; 0 is an insulated tip
    """
    left = m * (length - np.asarray(position, dtype=float))
    scale = np.cosh(m * length) + tip_biot_m * np.sinh(m * length)
    return np.asarray(root_rise * (np.cosh(left) + tip_biot_m * np.sinh(left)) / scale)


def fin_heat_flow(
    length: float, root_rise: float, m: float, conductivity: float, section: float, tip_biot_m: float = 0.0
) -> float:
    """Heat flow [W] into the root of that fin, [3] table 3.4; k [W/(m.K)], A [m2], others as `fin_rise`."""
    s, c = np.sinh(m * length), np.cosh(m * length)
    return float(conductivity * section * m * root_rise * (s + tip_biot_m * c) / (c + tip_biot_m * s))


def fin_elongation(
    span: float, length: float, root_rise: float, m: float, expansion: float, tip_biot_m: float = 0.0
) -> float:
    """Elongation [m] of the first `span` [m] of that fin: alpha times the integral of `fin_rise`."""
    scale = np.cosh(m * length) + tip_biot_m * np.sinh(m * length)
    left = m * (length - span)
    integral = np.sinh(m * length) - np.sinh(left) + tip_biot_m * (np.cosh(m * length) - np.cosh(left))
    return float(expansion * root_rise * integral / (m * scale))


def bar_fourier_rise(
    position: ArrayLike, time: float, length: float, rise: float, diffusivity: float
) -> Array:
    """Temperature rise [K] of an insulated bar with its end x = 0 held at `rise` [K] from t = 0, [2] ch. 3.

    The series is summed to the last term above rounding; `position`, `length` [m], `time` [s] > 0,
    `diffusivity` [m2/s].
    """
    x = np.asarray(position, dtype=float)
    decay = diffusivity * time * (np.pi / (2 * length)) ** 2
    terms = int(np.ceil(np.sqrt(40 / decay))) + 1
    odd = 2 * np.arange(terms) + 1
    series = np.exp(-(odd**2) * decay) / odd * np.sin(odd * np.pi * x[..., None] / (2 * length))
    return np.asarray(rise * (1 - 4 / np.pi * series.sum(axis=-1)))


def thermal_bending(position: ArrayLike, gradient: float, expansion: float) -> Array:
    """Deflection [m] of a free bar clamped at 0 with temperature linear through its thickness.

    The curvature is alpha dT/dz, so w = alpha (dT/dz) x^2 / 2 up to the sign of z; `gradient` [K/m],
    `position` [m].
    """
    return np.asarray(expansion * gradient * np.asarray(position, dtype=float) ** 2 / 2)
