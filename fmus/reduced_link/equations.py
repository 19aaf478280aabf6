"""Heat in a link of any shape by a few patterns of temperature, and the motion of its tool point.

    c dz/dt = -(k K + sum of h_g B_g) z + sources,   T = T_initial + patterns z,   displacement = alpha D z

from finite elements by projection (A. C. Antoulas, *Approximation of Large-Scale Dynamical Systems*, SIAM
2005). Matrices without parameters are data; `ReducedModel` says what each is.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, matrix, maximum, stack, total, where
from warmlink.fmus.reduced_link.model import Array, ReducedModel
from warmlink.fmus.thermal_link.equations import (
    STEFAN_BOLTZMANN,
    ambient_temperature,
    convection_coefficient,
)

PEAK_TIME = 1.0
"""s in which a peak follows what exceeds it."""


def derive(p: Record, model: ReducedModel) -> Mapping[str, Number]:
    """Matrices of the rates: what base and tip carry is stored there besides.

    With the carried capacities, as shares of the material's, the amplitudes' rates are multiplied by the
    inverse of I + hub base_load base_row + tip tip_load tip_row, a change of rank two (Woodbury's formula).
    """
    capacity = p.density * p.specific_heat
    loads, rows = np.array([model.base_load, model.tip_load]), np.array([model.base_row, model.tip_row])
    share = [p.hub_heat_capacity / capacity, p.tip_heat_capacity / capacity]
    coupling = rows @ loads.T
    a, b = 1 + share[0] * coupling[0, 0], share[0] * coupling[0, 1]
    c, d = share[1] * coupling[1, 0], 1 + share[1] * coupling[1, 1]
    inverse = [[d / (a * d - b * c), -b / (a * d - b * c)], [-c / (a * d - b * c), a / (a * d - b * c)]]

    def shared(column: Array) -> Number:
        """Rate of the amplitudes due to a column of loads, shape (n,)."""
        held = [share[i] * float(rows[i] @ column) for i in range(2)]
        carried = [inverse[i][0] * held[0] + inverse[i][1] * held[1] for i in range(2)]
        return (column - loads[0] * carried[0] - loads[1] * carried[1]) / capacity

    def columns(constant: Array) -> Number:
        return stack(*(shared(column) for column in constant.T))

    base, tip = shared(model.base_load), shared(model.tip_load)
    losses = [
        p.hub_conductance * base * model.base_row[i] + p.tip_conductance * tip * model.tip_row[i]
        for i in range(model.order)
    ]
    return {
        "conduction": p.conductivity * columns(model.conduction) + stack(*losses),
        "cooling": stack(*(columns(each) for each in model.cooling)),
        "base_load": base,
        "tip_load": tip,
        "surface_load": stack(*(shared(each) for each in model.surface_load)),
    }


def rates(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Mapping[str, Number]:
    """Time derivatives of the states: amplitudes in K/s, heat received in W, peaks in units of theirs."""
    n = model.order
    coefficients = film_coefficients(u, p, model)
    inflow = _inflow(u, p, time, model)
    decay, loads = p.conduction, p.base_load * inflow[0] + p.tip_load * inflow[1]
    for g, h in enumerate(coefficients):
        decay = decay + h * p.cooling[g * n * n : (g + 1) * n * n]
        loads = loads + p.surface_load[g * n : (g + 1) * n] * inflow[2 + g]
    beyond = [maximum(absolute(each) - x.peak[i], 0.0) for i, each in enumerate(inflow)]
    return {
        "amplitude": loads - matrix(decay, n).T @ x.amplitude,
        "heat_received": u.heat_flow,
        "peak": stack(*beyond) / PEAK_TIME,
    }


def outputs(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Mapping[str, Number]:
    """Temperatures in K, displacement in m, rotation in rad, heat in W and J, bounds of their errors."""
    start, rise = p.initial_temperature, x.amplitude
    reference = where(p.reference_temperature > 0, p.reference_temperature, start)
    displacement = p.expansion_coefficient * (
        model.displacement_rows @ rise + model.reach * (start - reference)
    )
    along = model.reach / np.linalg.norm(model.reach)
    elongation = total(along * displacement)
    ambient = ambient_temperature(u, p, time)
    coefficients = film_coefficients(u, p, model)
    above = model.surface_rows @ rise + model.area * (start - ambient)
    loss = total(stack(*coefficients) * above) - p.absorbed_flux * float(model.area.sum())
    largest = [maximum(x.peak[i], absolute(each)) for i, each in enumerate(_inflow(u, p, time, model))]
    error = model.error_gain @ stack(*largest) / p.conductivity
    return {
        "base_temperature": start + total(model.base_row * rise),
        "tip_temperature": start + total(model.tip_row * rise),
        "sensor_temperature": start + model.sensor_rows @ rise,
        "elongation": elongation,
        "surface_heat_loss": loss,
        "heat_received": x.heat_received,
        "discretisation_error": model.discretisation * absolute(elongation),
        "displacement": displacement,
        "rotation": p.expansion_coefficient * (model.rotation_rows @ rise),
        "displacement_error_bound": p.expansion_coefficient * error[0],
        "rotation_error_bound": p.expansion_coefficient * error[1],
        "temperature_error_bound": error[2],
    }


def begin(u: Record, p: Record, model: ReducedModel) -> Mapping[str, Number]:
    """States at the start: the initial temperature plus the initial rises given at the sensors."""
    return {
        "amplitude": model.initial_rows @ p.initial_temperature_rise,
        "heat_received": 0.0,
        "peak": np.zeros(2 + model.surfaces),
    }


def film_coefficients(u: Record, p: Record, model: ReducedModel) -> list[Number]:
    """Heat lost by each cooled surface in W/(m2.K): by convection, and by radiation linearised.

    e s (T^4 - T_a^4) is taken for 4 e s T_r^3 (T - T_a), T_r being `radiation_temperature`.
    """
    convection = convection_coefficient(u, p, float(np.linalg.norm(model.reach)) / 2)
    radiation = 4 * p.emissivity * STEFAN_BOLTZMANN * p.radiation_temperature**3
    return [p.convection_factor[g] * convection + radiation for g in range(model.surfaces)]


def _inflow(u: Record, p: Record, time: Number, model: ReducedModel) -> list[Number]:
    """Heat into a link at its initial temperature: at base and tip in W, into each surface in W/m2."""
    rise = ambient_temperature(u, p, time) - p.initial_temperature
    sink = u.tip_sink_temperature - u.ambient_temperature + rise
    fluxes = [h * rise + p.absorbed_flux for h in film_coefficients(u, p, model)]
    return [u.heat_flow + p.hub_conductance * rise, u.tip_heat_flow + p.tip_conductance * sink, *fluxes]
