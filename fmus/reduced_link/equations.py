"""Heat in a link of any shape by a few patterns of temperature, and the motion of its tool point.

    V c dz/dt = -(k K + sum of h_g B_g) z + sources,   T = T_initial + patterns z,   displacement = alpha D z

from finite elements by projection (A. C. Antoulas, *Approximation of Large-Scale Dynamical Systems*, SIAM
2005). Matrices without parameters are data; `ReducedModel` says what each is.
"""

from collections.abc import Sequence

import numpy as np

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total, where
from warmlink.fmus.reduced_link.model import ReducedModel
from warmlink.fmus.thermal_link.equations import (
    STEFAN_BOLTZMANN,
    ambient_temperature,
    convection_coefficient,
)

PEAK_TIME = 1.0
"""s in which a peak follows what exceeds it."""


def derive(p: Record, model: ReducedModel) -> Values:
    """Heat capacity of each pattern in J/K: that of the whole part."""
    return {"pattern_heat_capacity": p.density * p.specific_heat * model.volume * np.ones(model.order)}


def rates(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Values:
    """Time derivatives of the states: patterns in K/s, heat received in W, peaks in units of theirs."""
    z = x.pattern_temperature
    inflow = _inflow(u, p, time, model)
    at_base = inflow[0] - p.hub_conductance * total(model.base_row * z)
    at_tip = inflow[1] - p.tip_conductance * total(model.tip_row * z)
    gain = model.base_row * at_base + model.tip_row * at_tip - p.conductivity * model.conduction * z
    for g, h in enumerate(film_coefficients(u, p, model)):
        gain = gain + model.surface_rows[g] * inflow[2 + g] - h * (model.cooling[g] @ z)
    beyond = [maximum(each - x.peak[i], 0.0) for i, each in enumerate(_driving(z, u, p, time, model))]
    return {
        "pattern_temperature": _solved(p.pattern_heat_capacity, _carried(p), gain, model),
        "heat_received": u.heat_flow,
        "peak": stack(*beyond) / PEAK_TIME,
    }


def solve(right: Record, p: Record, step: Number, model: ReducedModel) -> Values:
    """Solve (I - step J) y = right with conduction, hub and tip in J; cooling and the peaks are not stiff."""
    carried, z = _carried(p), right.pattern_temperature
    stored = p.pattern_heat_capacity * z
    for held, row in zip(carried, (model.base_row, model.tip_row), strict=True):
        stored = stored + held * total(row * z) * row
    diagonal = p.pattern_heat_capacity + step * p.conductivity * model.conduction
    weights = [carried[0] + step * p.hub_conductance, carried[1] + step * p.tip_conductance]
    return {
        "pattern_temperature": _solved(diagonal, weights, stored, model),
        "heat_received": right.heat_received,
        "peak": right.peak,
    }


def _carried(p: Record) -> list[Number]:
    return [p.hub_heat_capacity, p.tip_heat_capacity]


def _solved(diagonal: Number, weights: Sequence[Number], right: Number, model: ReducedModel) -> Number:
    """Solve (diagonal + w_1 base_row base_row' + w_2 tip_row tip_row') y = right by Woodbury's formula."""
    rows = model.base_row, model.tip_row
    columns, plain = [row / diagonal for row in rows], right / diagonal
    seen = [weights[i] * total(rows[i] * plain) for i in range(2)]
    (a, b), (c, d) = (
        [float(i == j) + weights[i] * total(rows[i] * columns[j]) for j in range(2)] for i in range(2)
    )
    determinant = a * d - b * c
    first, second = (d * seen[0] - b * seen[1]) / determinant, (a * seen[1] - c * seen[0]) / determinant
    return plain - columns[0] * first - columns[1] * second


def outputs(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Values:
    """Temperatures in K, displacement in m, rotation in rad, heat in W and J, bounds of their errors."""
    start, rise = p.initial_temperature, x.pattern_temperature
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
    largest = [maximum(x.peak[i], each) for i, each in enumerate(_driving(rise, u, p, time, model))]
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


def begin(u: Record, p: Record, model: ReducedModel) -> Values:
    """States at the start: the initial temperature plus the initial rises given at the sensors."""
    return {
        "pattern_temperature": model.initial_rows @ p.initial_temperature_rise,
        "heat_received": 0.0,
        "peak": np.zeros(2 + 2 * model.surfaces),
    }


def _driving(z: Number, u: Record, p: Record, time: Number, model: ReducedModel) -> list[Number]:
    """Sizes of what the error follows: inputs in W and W/m2, and what motion adds to convection in W/m2.

    The gains are those of constant coefficients. With h' at rest, h (T_a - T) in motion is h' (T_a - T) and a
    flux (h - h') (T_a - T), which is at most that of the end whose temperature differs most.
    """
    inflow = _inflow(u, p, time, model)
    ambient = ambient_temperature(u, p, time) - p.initial_temperature
    ends = [absolute(total(row * z) - ambient) for row in (model.base_row, model.tip_row)]
    moving = absolute(convection_coefficient(u, p, _lever(model)) - p.convection_still)
    added = [p.convection_factor[g] * moving * maximum(*ends) for g in range(model.surfaces)]
    return [*(absolute(each) for each in inflow), *added]


def film_coefficients(u: Record, p: Record, model: ReducedModel) -> list[Number]:
    """Heat lost by each cooled surface in W/(m2.K): by convection, and by radiation linearised.

    e s (T^4 - T_a^4) is taken for 4 e s T_r^3 (T - T_a), T_r being `radiation_temperature`.
    """
    convection = convection_coefficient(u, p, _lever(model))
    radiation = 4 * p.emissivity * STEFAN_BOLTZMANN * p.radiation_temperature**3
    return [p.convection_factor[g] * convection + radiation for g in range(model.surfaces)]


def _lever(model: ReducedModel) -> float:
    """Half the distance in m from base to tool point, where the speed is that of the surface in the mean."""
    return float(np.linalg.norm(model.reach)) / 2


def _inflow(u: Record, p: Record, time: Number, model: ReducedModel) -> list[Number]:
    """Heat into a link at its initial temperature: at base and tip in W, into each surface in W/m2."""
    rise = ambient_temperature(u, p, time) - p.initial_temperature
    sink = u.tip_sink_temperature - u.ambient_temperature + rise
    fluxes = [h * rise + p.absorbed_flux for h in film_coefficients(u, p, model)]
    return [u.heat_flow + p.hub_conductance * rise, u.tip_heat_flow + p.tip_conductance * sink, *fluxes]
