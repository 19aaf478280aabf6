"""Heat in a link of any shape by a few patterns of temperature, and the motion of its tool point.

    V c dz/dt = -(k K + sum of h_g B_g) z + sources,   T = T_initial + patterns z,   displacement = alpha D z

from finite elements by projection (A. C. Antoulas, *Approximation of Large-Scale Dynamical Systems*, SIAM
2005). Matrices without parameters are data; `ReducedModel` says what each is.
"""

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, absolute, maximum, stack, total, where
from warmlink.fmus.thermal_link.equations import STEFAN_BOLTZMANN, ambient_temperature, convection_coefficient

Array = NDArray[np.float64]

PEAK_TIME = 1.0
"""s in which a peak follows what exceeds it."""

STORED = "resources/reduced_link.json"
"""File in a reduced link's FMU that holds its model."""


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A body's heat and growth by n patterns of temperature, for the material in its parameters.

    The temperature is the initial one plus the patterns times their amplitudes z [K]:

        V c dz/dt = -(k conduction + sum of h_g cooling_g) z + loads (Q, Q_tip, f_1, ...)

    with c the heat capacity of a unit volume [J/(m3.K)], k the conductivity, h_g the convection coefficient
    of the surface g and f_g the heat flux into it. G surfaces are cooled. The mean over the volume V of the
    product of two patterns is 1 for equal ones and 0 for others; the first is 1 everywhere.

    Attributes
    ----------
    material : nominal `conductivity`, `density`, `specific_heat` and `expansion_coefficient` in SI units
    volume : of the body [m3]
    conduction : of each pattern, shape (n,) [m]
    cooling : shape (G, n, n) [m2]
    loads : of 1 W at base and tip, which also give the mean temperatures there, and of 1 W/m2 on each
        surface, shape (n, 2 + G)
    outputs : displacement [m] and rotation [rad] of the tool for an expansion coefficient of 1, and the
        temperatures of the sensors, shape (3 + 3 + 8, n)
    reach : from the middle of the heated face to the tool point, shape (3,) [m]
    initial : amplitudes for a rise of 1 K at each sensor, shape (n, 8)
    error_gain : largest error of displacement [m], rotation [rad] and temperature [K], times the
        conductivity, for each load, and for each change of a surface's convection by 1 W/(m2.K) where an end
        is 1 K from its surroundings, shape (3, 2 + 2 G); an expansion coefficient of 1 for the first two
    discretisation : error of the elongation due to the mesh, as a share of it
    conductivity_range, convection_range : for which `error_gain` was computed, in SI units
    """

    material: dict[str, float]
    volume: float
    conduction: Array
    cooling: Array
    loads: Array
    outputs: Array
    reach: Array
    initial: Array
    error_gain: Array
    discretisation: float
    conductivity_range: tuple[float, float]
    convection_range: tuple[float, float]

    @property
    def order(self) -> int:
        """Number of patterns."""
        return len(self.conduction)

    @property
    def area(self) -> Array:
        """Area of each cooled surface, shape (G,) [m2]."""
        return self.loads[0, 2:]


def stored(model: ReducedModel) -> bytes:
    """Content of the file `STORED`."""
    return json.dumps(asdict(model), default=lambda array: array.tolist()).encode()


def read_stored(content: bytes) -> ReducedModel:
    """Model in the content of the file `STORED`."""
    held: dict[str, Any] = json.loads(content)
    for name, value in held.items():
        if isinstance(value, list):
            held[name] = tuple(value) if name.endswith("_range") else np.array(value)
    return ReducedModel(**held)


def derive(p: Record, model: ReducedModel) -> Values:
    """Heat capacity of each pattern in J/K: that of the whole part."""
    return {"pattern_heat_capacity": p.density * p.specific_heat * model.volume * np.ones(model.order)}


def begin(u: Record, p: Record, model: ReducedModel) -> Values:
    """States at the start: the initial temperature plus the initial rises given at the sensors."""
    return {
        "pattern_temperature": model.initial @ p.initial_temperature_rise,
        "heat_received": 0.0,
        "peak": np.zeros(model.error_gain.shape[1]),
    }


def rates(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Values:
    """Time derivatives of the states: patterns in K/s, heat received in W, peaks in units of theirs."""
    z, (base, tip, *fluxes) = x.pattern_temperature, _loads(u, p, time, model)
    ends = _ends(z, model)
    flows = stack(base - p.hub_conductance * ends[0], tip - p.tip_conductance * ends[1], *fluxes)
    gain = model.loads @ flows - p.conductivity * model.conduction * z
    for cooling, h in zip(model.cooling, film_coefficients(u, p, model), strict=True):
        gain = gain - h * (cooling @ z)
    beyond = [maximum(each - x.peak[i], 0.0) for i, each in enumerate(_driving(z, u, p, time, model))]
    return {
        "pattern_temperature": _solved(p, 0.0, gain, model),
        "heat_received": u.heat_flow,
        "peak": stack(*beyond) / PEAK_TIME,
    }


def solve(right: Record, p: Record, step: Number, model: ReducedModel) -> Values:
    """Solve (I - step J) y = right with conduction, hub and tip in J; cooling and the peaks are not stiff."""
    z, carried = right.pattern_temperature, stack(p.hub_heat_capacity, p.tip_heat_capacity)
    stored = p.pattern_heat_capacity * z + model.loads[:, :2] @ (carried * _ends(z, model))
    return {
        "pattern_temperature": _solved(p, step, stored, model),
        "heat_received": right.heat_received,
        "peak": right.peak,
    }


def outputs(x: Record, u: Record, p: Record, time: Number, model: ReducedModel) -> Values:
    """Temperatures in K, displacement in m, rotation in rad, heat in W and J, bounds of their errors."""
    start, z = p.initial_temperature, x.pattern_temperature
    reference = where(p.reference_temperature > 0, p.reference_temperature, start)
    ends, seen = _ends(z, model), model.outputs @ z
    displacement = p.expansion_coefficient * (seen[:3] + model.reach * (start - reference))
    elongation = total(model.reach / np.linalg.norm(model.reach) * displacement)
    above = model.loads[:, 2:].T @ z + model.area * (start - ambient_temperature(u, p, time))
    lost = total(stack(*film_coefficients(u, p, model)) * above) - p.absorbed_flux * float(model.area.sum())
    largest = [maximum(x.peak[i], each) for i, each in enumerate(_driving(z, u, p, time, model))]
    error = model.error_gain @ stack(*largest) / p.conductivity
    return {
        "base_temperature": start + ends[0],
        "tip_temperature": start + ends[1],
        "sensor_temperature": start + seen[6:],
        "elongation": elongation,
        "surface_heat_loss": lost,
        "heat_received": x.heat_received,
        "discretisation_error": model.discretisation * absolute(elongation),
        "displacement": displacement,
        "rotation": p.expansion_coefficient * seen[3:6],
        "displacement_error_bound": p.expansion_coefficient * error[0],
        "rotation_error_bound": p.expansion_coefficient * error[1],
        "temperature_error_bound": error[2],
    }


def film_coefficients(u: Record, p: Record, model: ReducedModel) -> list[Number]:
    """Heat lost by each cooled surface in W/(m2.K): by convection, and by radiation linearised.

    e s (T^4 - T_a^4) is taken for 4 e s T_r^3 (T - T_a), T_r being `radiation_temperature`.
    """
    convection = convection_coefficient(u, p, _lever(model))
    radiation = 4 * p.emissivity * STEFAN_BOLTZMANN * p.radiation_temperature**3
    return [p.convection_factor[g] * convection + radiation for g in range(model.area.size)]


def _lever(model: ReducedModel) -> float:
    """Half the distance in m from base to tool point, where the speed is that of the surface in the mean."""
    return float(np.linalg.norm(model.reach)) / 2


def _ends(z: Number, model: ReducedModel) -> Number:
    """Mean temperatures of the heated face and of the tool's above the initial one, in K."""
    return model.loads[:, :2].T @ z


def _loads(u: Record, p: Record, time: Number, model: ReducedModel) -> list[Number]:
    """Heat into a link at its initial temperature: at base and tip in W, into each surface in W/m2."""
    rise = ambient_temperature(u, p, time) - p.initial_temperature
    sink = u.tip_sink_temperature - u.ambient_temperature + rise
    fluxes = [h * rise + p.absorbed_flux for h in film_coefficients(u, p, model)]
    return [u.heat_flow + p.hub_conductance * rise, u.tip_heat_flow + p.tip_conductance * sink, *fluxes]


def _driving(z: Number, u: Record, p: Record, time: Number, model: ReducedModel) -> list[Number]:
    """Sizes of what the error follows: loads in W and W/m2, and what motion adds to convection in W/m2.

    The gains are those of constant coefficients. With h' at rest, h (T_a - T) in motion is h' (T_a - T) and a
    flux (h - h') (T_a - T), which is at most that of the end whose temperature differs most.
    """
    ambient = ambient_temperature(u, p, time) - p.initial_temperature
    ends = _ends(z, model)
    moving = absolute(convection_coefficient(u, p, _lever(model)) - p.convection_still)
    differs = maximum(absolute(ends[0] - ambient), absolute(ends[1] - ambient))
    added = [p.convection_factor[g] * moving * differs for g in range(model.area.size)]
    return [*(absolute(each) for each in _loads(u, p, time, model)), *added]


def _solved(p: Record, step: Number, right: Number, model: ReducedModel) -> Number:
    """Solve (C + step K) y = right, with what hub and tip carry in C, and what they lose in K.

    Their two terms of rank one are added at once by Woodbury's formula: one after the other, the second would
    wait for the first in each step.
    """
    inverse = 1.0 / (p.pattern_heat_capacity + step * p.conductivity * model.conduction)
    ends = model.loads[:, 0], model.loads[:, 1]
    at_hub = p.hub_heat_capacity + step * p.hub_conductance
    weights = at_hub, p.tip_heat_capacity + step * p.tip_conductance
    columns, plain = [end * inverse for end in ends], right * inverse
    at_base, at_tip = (weight * total(end * plain) for weight, end in zip(weights, ends, strict=True))
    (a, b), (c, d) = (
        [float(i == j) + weights[i] * total(ends[i] * columns[j]) for j in range(2)] for i in range(2)
    )
    determinant = a * d - b * c
    first, second = (d * at_base - b * at_tip) / determinant, (a * at_tip - c * at_base) / determinant
    return plain - columns[0] * first - columns[1] * second
