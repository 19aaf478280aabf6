"""Motor and link as one linear state space, by complex step through the components' own equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.motor_heat_source.equations import PAD_POWER
from warmlink.fmus.names import instead
from warmlink.fmus.packaging import limits
from warmlink.fmus.packaging.component import Component
from warmlink.fmus.packaging.integrator import COMPLEX_STEP
from warmlink.fmus.packaging.quantities import ROOM_TEMPERATURE
from warmlink.fmus.thermal_link.component import COMPONENT as LINK

Array = NDArray[np.float64]

_Items = tuple[tuple[str, float], ...]

INPUTS = ("winding_heat", "shaft_heat", "link_heat", "ambient_temperature")
"""Heat in W into winding, shaft and (spread over its surface) link, and the ambient temperature in K."""

OUTPUTS = (
    "shaft_temperature",
    "winding_temperature",
    "base_temperature",
    "middle_temperature",
    "tip_temperature",
    "elongation",
)

_TEMPERATURES = {"motor": ("winding_temperature", "shaft_temperature"), "link": ("temperature",)}
"""States that matter to the elongation; the heat counters do not."""


@dataclass(frozen=True)
class Plant:
    """Parameters of motor and link that differ from nominal, by name, in SI units."""

    motor: Mapping[str, float] = field(default_factory=dict)
    link: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LinearPlant:
    """Motor and link as deviations from one temperature, linear for each speed.

        dx/dt = (A + |speed| A_speed) x + (B + |speed| B_speed) u,    y = C x

    with x the temperatures of winding, shaft and link nodes in K above `temperature`, u the `INPUTS` and y
    the `OUTPUTS` (K, and m for the elongation). Convection grows with the speed, so the term in speed times
    state is kept; the losses of the motor are inputs, computed from duty and winding temperature elsewhere.

    Attributes
    ----------
    A, A_speed : shape (n, n), in 1/s and 1/rad
    B, B_speed : shape (n, 4)
    C : shape (6, n)
    heat_capacity : heat capacity in J/K of each state, shape (n,)
    temperature : temperature in K about which the plant is linear
    """

    A: Array
    A_speed: Array
    B: Array
    B_speed: Array
    C: Array
    heat_capacity: Array
    temperature: float

    def at(self, speed: float) -> tuple[Array, Array]:
        """State and input matrix at a speed in rad/s."""
        return self.A + abs(speed) * self.A_speed, self.B + abs(speed) * self.B_speed

    @property
    def elongation_per_kelvin(self) -> float:
        """Growth in m for a uniform rise by 1 K."""
        return float(np.sum(self.C[OUTPUTS.index("elongation")]))

    def link_loss(self, into: Array) -> float:
        """Conductance in W/K from the link's nodes to the surroundings that an input matrix holds."""
        link = slice(len(_TEMPERATURES["motor"]), None)
        return float(self.heat_capacity[link] @ into[link, INPUTS.index("ambient_temperature")])


def plant_model(plant: Plant | None = None, temperature: float = ROOM_TEMPERATURE) -> LinearPlant:
    """Linear state space of motor and link, joined as in the warm-up cell.

    Parameters
    ----------
    plant : parameters that differ from nominal
    temperature : temperature in K, of everything, about which to linearise

    Returns
    -------
    LinearPlant
        With 2 + (cells) states.

    Raises
    ------
    InputError
        A parameter is unknown or out of range.
    """
    plant = plant or Plant()
    return _model(tuple(sorted(plant.motor.items())), tuple(sorted(plant.link.items())), temperature)


@lru_cache(maxsize=64)
def _model(motor: _Items, link: _Items, temperature: float) -> LinearPlant:
    """The model, which takes half a second, kept for whoever asks for the same plant again."""
    cell = _Cell(Plant(dict(motor), dict(link)), temperature)
    still, moving = cell.state_matrix(0.0), cell.state_matrix(1.0)
    heats = [cell.winding_heat_column(), cell.shaft_heat_column(), cell.link_heat_column()]
    still_ambient, moving_ambient = cell.ambient_column(0.0), cell.ambient_column(1.0)
    none = np.zeros_like(still_ambient)
    return LinearPlant(
        A=still,
        A_speed=moving - still,
        B=np.column_stack([*heats, still_ambient]),
        B_speed=np.column_stack([none, none, none, moving_ambient - still_ambient]),
        C=cell.output_matrix(),
        heat_capacity=cell.heat_capacity(),
        temperature=temperature,
    )


def parameter_vector(component: Component, values: Mapping[str, float], instance: str) -> Array:
    """Flat parameters of a component, nominal but for the named values.

    Raises
    ------
    InputError
        A name is unknown or a value out of range.
    """
    vector = np.array([s.start for s in component.scalars()][: component.p.size], dtype=float)
    for name, value in values.items():
        if name not in component.p.index:
            raise InputError(
                f"{instance}.{name}: {component.name} has no such parameter; "
                f"{instead(name, [v.name for v in component.parameters])}"
            )
        vector[component.p.index[name]] = value
    for sentence in limits.problems(component, instance, vector.tolist()):
        raise InputError(sentence)
    return vector


class _Cell:
    """Motor and link with heat flow and base temperature exchanged without delay."""

    def __init__(self, plant: Plant, temperature: float) -> None:
        self._parameters = {
            "motor": parameter_vector(MOTOR, plant.motor, "motor"),
            "link": parameter_vector(LINK, plant.link, "link"),
        }
        self._temperature = temperature
        self._places = {
            "motor": [MOTOR.x.index[name] for name in _TEMPERATURES["motor"]],
            "link": [LINK.x.index[name] for name in LINK.x.names if name.startswith("temperature")],
        }
        self._split = len(self._places["motor"])
        self.size = self._split + len(self._places["link"])

    def state_matrix(self, speed: float) -> Array:
        """Derivative of the rates by the state, shape (n, n)."""
        return _matrix(lambda rise: self._rates(rise, speed=speed), self.size)

    def output_matrix(self) -> Array:
        """Derivative of the outputs by the state, shape (6, n)."""
        return _matrix(self._outputs, self.size)

    def ambient_column(self, speed: float) -> Array:
        """Derivative of the rates by the ambient temperature."""
        return _slope(lambda change: self._rates(speed=speed, ambient=change))

    def shaft_heat_column(self) -> Array:
        """Rates a watt into the shaft, which is where the pad's power goes."""
        return _slope(lambda change: self._rates(pad_power=change))

    def winding_heat_column(self) -> Array:
        """Rates a watt into the winding: any current heats it alone, its heat capacity says by how much."""
        by_current = _slope(lambda change: self._rates(current=1.0 + change))
        return by_current / (by_current @ self.heat_capacity())

    def link_heat_column(self) -> Array:
        """Rates a watt spread over the link's surface, as radiant heat is."""
        by_flux = _slope(lambda change: self._rates(absorbed_flux=change))
        return by_flux / (by_flux @ self.heat_capacity())

    def heat_capacity(self) -> Array:
        """Heat capacity in J/K of each state."""
        motor = MOTOR.p.read(self._parameters["motor"])
        link = LINK.d.read(LINK.settled(self._parameters["link"]))
        own = [motor.winding_heat_capacity, motor.shaft_heat_capacity]
        return np.concatenate([own, np.asarray(link.heat_capacity, dtype=float)])

    def _rates(
        self,
        rise: NDArray[np.complex128] | None = None,
        *,
        speed: float = 0.0,
        current: complex = 0.0,
        pad_power: complex = 0.0,
        ambient: complex = 0.0,
        absorbed_flux: complex = 0.0,
    ) -> NDArray[np.complex128]:
        motor_state, link_state = self._states(rise)
        surroundings = self._temperature + ambient
        link_values = {
            "ambient_temperature": surroundings,
            "speed": speed,
            "tip_sink_temperature": surroundings,
        }
        link_p = LINK.settled(self._parameters["link"]).astype(complex)
        link_p[LINK.p.index["absorbed_flux"]] += absorbed_flux
        motor_p = MOTOR.settled(self._parameters["motor"])

        base = _named(LINK, "base_temperature", link_state, _inputs(LINK, link_values), link_p)
        motor_u = _inputs(
            MOTOR,
            {
                "pad_mode": PAD_POWER,
                "pad_power": pad_power,
                "speed": speed,
                "current": current,
                "ambient_temperature": surroundings,
                "neighbour_temperature": surroundings,
                "link_base_temperature": base,
            },
        )
        heat_flow = _named(MOTOR, "heat_flow", motor_state, motor_u, motor_p)
        link_u = _inputs(LINK, {**link_values, "heat_flow": heat_flow})
        motor_rates = MOTOR.rates_of(motor_state, motor_u, motor_p, 0.0)[self._places["motor"]]
        link_rates = LINK.rates_of(link_state, link_u, link_p, 0.0)[self._places["link"]]
        return np.concatenate([motor_rates, link_rates])

    def _outputs(self, rise: NDArray[np.complex128]) -> NDArray[np.complex128]:
        motor_state, link_state = self._states(rise)
        link_p = LINK.settled(self._parameters["link"])
        link_y = LINK.y.read(LINK.outputs_of(link_state, _inputs(LINK, {}), link_p, 0.0))
        motor_y = MOTOR.y.read(
            MOTOR.outputs_of(motor_state, _inputs(MOTOR, {}), self._parameters["motor"], 0.0)
        )
        sensed = link_y.sensor_temperature
        return np.array(
            [
                motor_y.shaft_temperature,
                motor_y.winding_temperature,
                link_y.base_temperature,
                sensed[1],
                link_y.tip_temperature,
                link_y.elongation,
            ]
        )

    def _states(
        self, rise: NDArray[np.complex128] | None
    ) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        temperatures = self._temperature + (np.zeros(self.size) if rise is None else rise)
        states = []
        for component, name, part in (
            (MOTOR, "motor", slice(0, self._split)),
            (LINK, "link", slice(self._split, None)),
        ):
            state = np.zeros(component.x.size, dtype=complex)
            state[self._places[name]] = temperatures[part]
            states.append(state)
        return states[0], states[1]


def _slope(function: Callable[[complex], NDArray[np.complex128]]) -> Array:
    """Derivative at 0 by a complex step."""
    return np.imag(function(1j * COMPLEX_STEP)) / COMPLEX_STEP


def _matrix(function: Callable[[NDArray[np.complex128]], NDArray[np.complex128]], size: int) -> Array:
    """Derivative at 0 by a vector of a size, a column each."""
    units = 1j * COMPLEX_STEP * np.eye(size, dtype=np.complex128)
    return np.column_stack([np.imag(function(unit)) / COMPLEX_STEP for unit in units])


def _inputs(component: Component, values: Mapping[str, complex]) -> NDArray[np.complex128]:
    vector = np.array([v.start for v in component.inputs], dtype=complex)
    for name, value in values.items():
        vector[component.u.index[name]] = value
    return vector


def _named(
    component: Component, name: str, x: NDArray[np.complex128], u: NDArray[np.complex128], p: Array
) -> complex:
    values = component.outputs_of(x, u, p, 0.0)
    return complex(values[component.y.index[name]])
