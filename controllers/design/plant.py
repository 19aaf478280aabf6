"""Motor and link as one linear state space, one matrix for each effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.linearise import Point, outputs_by, rates_by, start
from warmlink.fmus.component import Component, limits
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER
from warmlink.fmus.plant import plant

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

_READ = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
    "link.elongation",
)
"""Where the plant gives the outputs."""

_SURROUNDINGS = ("motor.ambient_temperature", "link.ambient_temperature", "link.tip_sink_temperature")


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
        link = slice(2, None)  # after winding and shaft
        return float(self.heat_capacity[link] @ into[link, INPUTS.index("ambient_temperature")])


def plant_model(given: Plant | None = None, temperature: float = ROOM_TEMPERATURE) -> LinearPlant:
    """Linear state space of motor and link, joined as in the warm-up cell.

    Parameters
    ----------
    given : parameters that differ from nominal
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
    given = given or Plant()
    return _model(tuple(sorted(given.motor.items())), tuple(sorted(given.link.items())), temperature)


@lru_cache(maxsize=64)
def _model(motor: _Items, link: _Items, temperature: float) -> LinearPlant:
    """The model, which takes a tenth of a second, kept for whoever asks for the same plant again."""
    joined = plant()
    given = {f"motor.{name}": value for name, value in motor} | {
        f"link.{name}": value for name, value in link
    }
    still, moving = (_still_at(temperature, given, speed) for speed in (0.0, 1.0))
    settled = joined.d.read(joined.settled(still.p))
    heat_capacity = np.concatenate(
        [
            [settled.motor.winding_heat_capacity, settled.motor.shaft_heat_capacity],
            np.asarray(settled.link.heat_capacity, dtype=float),
        ]
    )
    kept = [joined.continuous.index[name] for name in _temperatures()]

    def heat(variable: str, at: Point) -> Array:
        """Rates per watt of what a variable heats; the heat capacities tell how many watts it is."""
        column = rates_by(joined, at, [variable])[kept, 0]
        return column / (column @ heat_capacity)

    def state_matrix(at: Point) -> Array:
        return rates_by(joined, at, _temperatures())[kept]

    def ambient(at: Point) -> Array:
        return rates_by(joined, at, _SURROUNDINGS)[kept].sum(axis=1)

    # A current heats the winding alone, a pad's power the shaft, absorbed radiation the link's surface.
    loaded = replace(still, u=still.u.copy())
    loaded.u[joined.u.index["motor.current"]] = 1.0
    heats = [heat("motor.current", loaded), heat("motor.pad_power", still), heat("link.absorbed_flux", still)]
    A, into = state_matrix(still), ambient(still)
    none = np.zeros_like(into)
    return LinearPlant(
        A=A,
        A_speed=state_matrix(moving) - A,
        B=np.column_stack([*heats, into]),
        B_speed=np.column_stack([none, none, none, ambient(moving) - into]),
        C=outputs_by(joined, still, _temperatures())[[joined.y.index[name] for name in _READ]],
        heat_capacity=heat_capacity,
        temperature=temperature,
    )


def _temperatures() -> list[str]:
    """States that matter to the elongation; the heat counters do not."""
    return [name for name in plant().continuous.names if "temperature" in name]


def _still_at(temperature: float, given: Mapping[str, float], speed: float) -> Point:
    """Everything at one temperature in K, nothing heated."""
    starts = dict.fromkeys(
        ("motor.initial_winding_temperature", "motor.initial_shaft_temperature", "link.initial_temperature"),
        temperature,
    )
    inputs = dict.fromkeys((*_SURROUNDINGS, "motor.neighbour_temperature"), temperature) | {
        "motor.speed": speed,
        "link.speed": speed,
        "motor.pad_mode": PAD_POWER,
    }
    return start(plant(), {**starts, **given, **inputs})


def parameter_vector(component: Component, values: Mapping[str, float], instance: str) -> Array:
    """Flat parameters of a component, nominal but for the named values.

    Raises
    ------
    InputError
        A name is unknown or a value out of range.
    """
    for name in values:
        if name not in component.p.index:
            raise InputError(limits.unknown(component, instance, name))
    vector: Array = component.start_values(values)[0]
    for sentence in limits.problems(component, instance, vector.tolist()):
        raise InputError(sentence)
    return vector
