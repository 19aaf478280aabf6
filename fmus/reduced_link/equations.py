"""Heat in a link of any shape by a few patterns of temperature, and the motion of its tool point.

    c dz/dt = -(k K + sum of h_g B_g) z + sources,   T = T_initial + patterns z,   displacement = alpha D z

from finite elements by projection (A. C. Antoulas, *Approximation of Large-Scale Dynamical Systems*, SIAM
2005). Matrices without parameters are data; `ReducedModel` says what each is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total, where
from warmlink.fmus.reduced_link.model import ReducedModel
from warmlink.fmus.thermal_link.equations import (
    STEFAN_BOLTZMANN,
    ambient_temperature,
    convection_coefficient,
)

PEAK_TIME = 1.0
"""s in which a peak follows what exceeds it."""


def rates(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Mapping[str, Number]:
    """Time derivatives of the states: amplitudes in K/s, heat received in W, peaks in units of theirs."""
    z = x.amplitude
    inflow = _inflow(u, p, time, model)
    at_base = inflow[0] - p.hub_conductance * total(model.base_row * z)
    at_tip = inflow[1] - p.tip_conductance * total(model.tip_row * z)
    gain = model.base_load * at_base + model.tip_load * at_tip - p.conductivity * (model.conduction @ z)
    for g, h in enumerate(film_coefficients(u, p, model)):
        gain = gain + model.surface_load[g] * inflow[2 + g] - h * (model.cooling[g] @ z)
    capacity = p.density * p.specific_heat
    carried = [p.hub_heat_capacity / capacity, p.tip_heat_capacity / capacity]
    beyond = [maximum(absolute(each) - x.peak[i], 0.0) for i, each in enumerate(inflow)]
    return {
        "amplitude": _with_ends(lambda each: each, carried, gain, model) / capacity,
        "heat_received": u.heat_flow,
        "peak": stack(*beyond) / PEAK_TIME,
    }


def solve(right: Record, p: Record, step: Number, model: ReducedModel) -> Mapping[str, Number]:
    """Solve (I - step J) y = right with conduction, hub and tip in J; cooling and the peaks are not stiff."""
    capacity = p.density * p.specific_heat
    carried = [p.hub_heat_capacity / capacity, p.tip_heat_capacity / capacity]
    stored = model.base_load * carried[0] * total(model.base_row * right.amplitude)
    stored = stored + model.tip_load * carried[1] * total(model.tip_row * right.amplitude)
    share = step / capacity
    weights = [carried[0] + share * p.hub_conductance, carried[1] + share * p.tip_conductance]
    conducted = partial(_conducted, share=share * p.conductivity, model=model)
    return {
        "amplitude": _with_ends(conducted, weights, right.amplitude + stored, model),
        "heat_received": right.heat_received,
        "peak": right.peak,
    }


def _conducted(right: Number, share: Number, model: ReducedModel) -> Number:
    """Solve (I + share conduction) y = right, one pattern or pair of patterns at a time."""
    diagonal = 1 + share * np.diag(model.conduction)
    partner, coupling = model.partners
    inverse = 1 / (diagonal**2 - share**2 * (coupling * coupling[partner]))
    return (diagonal * right - share * coupling * right[partner]) * inverse


def _with_ends(
    inverse: Callable[[Number], Number], weights: Sequence[Number], right: Number, model: ReducedModel
) -> Number:
    """Solve (D + w_1 base_load base_row + w_2 tip_load tip_row) y = right by Woodbury's formula."""
    loads, rows = (model.base_load, model.tip_load), (model.base_row, model.tip_row)
    columns, plain = [inverse(load) for load in loads], inverse(right)
    seen = [weights[i] * total(rows[i] * plain) for i in range(2)]
    (a, b), (c, d) = (
        [float(i == j) + weights[i] * total(rows[i] * columns[j]) for j in range(2)] for i in range(2)
    )
    determinant = a * d - b * c
    first, second = (d * seen[0] - b * seen[1]) / determinant, (a * seen[1] - c * seen[0]) / determinant
    return plain - columns[0] * first - columns[1] * second


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
