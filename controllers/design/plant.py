"""Motor and link as one linear state space, one matrix for each effect."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.design.linearise import Point, python_control, slopes, start
from warmlink.controllers.interface import SENSED
from warmlink.controllers.observer.model import LOSSES
from warmlink.fmus.component import Component
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.equations import PAD_POWER
from warmlink.fmus.plant import plant as motor_and_link

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]

_Items = tuple[tuple[str, float], ...]

NOMINAL: Mapping[str, float] = MappingProxyType({})
"""Nothing that differs from nominal."""

INPUTS = ("winding_heat", "shaft_heat", "link_heat", "ambient_temperature")
"""Heat in W into winding, shaft and (spread over its surface) link, and the ambient temperature in K."""

OUTPUTS = (*SENSED, "elongation")

_READ = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
)
"""Where the plant of the warm-up cell gives the temperatures."""


@dataclass(frozen=True, eq=False)
class Plant:
    """Motors and links to design for, and what a law sees of them.

    Attributes
    ----------
    component : the motors and links, joined
    given : parameters that differ from nominal, in SI units by name
    motors, links : instances; the same duty drives all motors
    read : variable behind each temperature that the law reads
    growth : what the law corrects, weights of variables
    """

    component: Component
    given: Mapping[str, float]
    motors: tuple[str, ...]
    links: tuple[str, ...]
    read: Mapping[str, str]
    growth: Mapping[str, float]

    @property
    def surroundings(self) -> list[str]:
        """Inputs that are temperatures of the surroundings."""
        ends = (".ambient_temperature", ".tip_sink_temperature")
        return [name for name in self.component.u.names if name.endswith(ends)]

    @property
    def motor(self) -> dict[str, float]:
        """Parameters of the motors that differ from nominal.

        Raises
        ------
        InputError
            The motors differ from each other in how they lose power, of which a law knows one motor.
        """
        each = [self.given_of(motor) for motor in self.motors]
        for name in LOSSES:
            if len({values.get(name) for values in each}) > 1:
                raise InputError(
                    f"{', '.join(self.motors)}: differ in {name}, and a law knows the losses of one motor; "
                    "design for one of them, or make them alike"
                )
        return each[0]

    def given_of(self, instance: str) -> dict[str, float]:
        """Parameters of one instance that differ from nominal."""
        split = ((name.rpartition("."), value) for name, value in self.given.items())
        return {name: value for (owner, _, name), value in split if owner == instance}


def cell_plant(motor: Mapping[str, float] = NOMINAL, link: Mapping[str, float] = NOMINAL) -> Plant:
    """Motor and link of a warm-up cell, from what differs from nominal, by parameter in SI units."""
    return _cell(*(tuple(sorted(values.items())) for values in (motor, link)))


@lru_cache(maxsize=64)
def _cell(motor: _Items, link: _Items) -> Plant:
    given = {f"motor.{name}": value for name, value in motor} | {f"link.{name}": v for name, v in link}
    read = dict(zip(OUTPUTS, _READ, strict=False))
    return Plant(motor_and_link(), given, ("motor",), ("link",), read, {"link.elongation": 1.0})


@dataclass(frozen=True)
class LinearBySpeed:
    """A linear model for each speed, whose inputs u are the `INPUTS` and whose outputs y the `OUTPUTS`.

        dx/dt = (A + |speed| A_speed) x + (B + |speed| B_speed) u,    y = C x

    Convection grows with the speed, so the term in speed times state is kept; the losses of the motor are
    inputs, computed from duty and winding temperature elsewhere.

    Attributes
    ----------
    A, A_speed : shape (n, n), in 1/s and 1/rad
    B, B_speed : shape (n, 4)
    C : shape (6, n)
    """

    A: Array
    A_speed: Array
    B: Array
    B_speed: Array
    C: Array

    def at(self, speed: float) -> tuple[Array, Array]:
        """State and input matrix at a speed in rad/s."""
        return self.A + abs(speed) * self.A_speed, self.B + abs(speed) * self.B_speed

    def state_space(self, speed: float) -> "control.StateSpace":
        """The model at a speed in rad/s for python-control, from `INPUTS` to `OUTPUTS`.

        MissingExtraError if that is not installed.
        """
        ss = python_control().ss
        return ss(*self.at(speed), self.C, 0, inputs=list(INPUTS), outputs=list(OUTPUTS))


@dataclass(frozen=True)
class LinearPlant(LinearBySpeed):
    """Motor and link as deviations from room temperature, about which they are linear.

    The states are the temperatures of winding, shaft and link nodes in K above it (of a reduced link the
    amplitudes of its patterns), the outputs are in K, and in m for the elongation.

    Attributes
    ----------
    heat_capacity : heat capacity in J/K of each state, shape (n,)
    uniform : states of everything being 1 K warmer, to which surroundings 1 K warmer lead, shape (n,)
    link_states : which of the states are the links'
    """

    heat_capacity: Array
    uniform: Array
    link_states: tuple[int, ...]

    @property
    def elongation_per_kelvin(self) -> float:
        """Growth in m for a uniform rise by 1 K."""
        return float(self.C[OUTPUTS.index("elongation")] @ self.uniform)

    def link_loss(self, into: Array) -> float:
        """Conductance in W/K from the link's nodes to the surroundings that an input matrix holds."""
        link = list(self.link_states)
        held = (self.heat_capacity * self.uniform)[link]
        return float(held @ into[link, INPUTS.index("ambient_temperature")])


USUAL_SPEED = 3.43
"""rad/s of the paper's continuous duty cycle, at which and at rest the linear plant has the link's losses."""


@lru_cache(maxsize=64)
def plant_model(given: Plant | None = None) -> LinearPlant:
    """Linear state space of motors and links; kept, as it takes a tenth of a second.

    Parameters
    ----------
    given : motors and links; those of the nominal warm-up cell by default

    Returns
    -------
    LinearPlant
        With 2 + (cells) states for each motor with its link.

    Raises
    ------
    InputError
        A parameter is unknown or out of range.
    """
    plant = given or cell_plant()
    joined = plant.component
    still, moving = (_at_rest(plant, speed) for speed in (0.0, USUAL_SPEED))
    states = [name for name in joined.continuous.names if "temperature" in name]
    kept = [joined.continuous.index[name] for name in states]
    heat_capacity = _heat_capacity(plant, still)

    def rates_by(names: Sequence[str], at: Point) -> Array:
        return slopes(joined.rates_of, joined, at, names)[kept]

    def heat(variable: str, instances: tuple[str, ...], at: Point) -> Array:
        """Rates per watt of what a variable heats; the heat capacities tell how many watts it is."""
        column = rates_by([f"{each}.{variable}" for each in instances], at).sum(axis=1)
        return column / (column @ (heat_capacity * uniform))

    A, moving_A = (rates_by(states, at) for at in (still, moving))
    into, moving_into = (rates_by(plant.surroundings, at).sum(axis=1) for at in (still, moving))
    uniform = np.asarray(np.linalg.solve(A, -into), dtype=float)
    # A current heats the windings alone, a pad's power the shafts, absorbed radiation the links' surfaces.
    loaded = replace(still, u=still.u.copy())
    for each in plant.motors:
        loaded.u[joined.u.index[f"{each}.current"]] = 1.0
    count = len(plant.motors)
    heats = [
        count * heat("current", plant.motors, loaded),
        count * heat("pad_power", plant.motors, still),
        heat("absorbed_flux", plant.links, still),
    ]
    none = np.zeros_like(into)
    return LinearPlant(
        A=A,
        A_speed=(moving_A - A) / USUAL_SPEED,
        B=np.column_stack([*heats, into]),
        B_speed=np.column_stack([none, none, none, (moving_into - into) / USUAL_SPEED]),
        C=_outputs(plant, slopes(joined.outputs_of, joined, still, states)),
        heat_capacity=heat_capacity,
        uniform=uniform,
        link_states=tuple(i for i, name in enumerate(states) if name.rpartition(".")[0] in plant.links),
    )


def no_growth(plant: Plant) -> float:
    """Temperature in K of all links at which what the law corrects is 0.

    Of links that count their growth from different temperatures, the mean by how much each grows.
    """
    joined, model = plant.component, plant_model(plant)
    even = {name: value for name, value in plant.given.items() if ".initial_temperature_rise" not in name}
    begun = start(joined, even)
    found = joined.outputs_of(begun.x, begun.u, joined.settled(begun.p), begun.time)
    grown = sum(weight * found[joined.y.index[name]] for name, weight in plant.growth.items())
    per_kelvin = model.elongation_per_kelvin
    if per_kelvin == 0:
        return ROOM_TEMPERATURE
    owners = [name.rpartition(".")[0] for name in joined.continuous.names if "temperature" in name]
    shares = model.C[OUTPUTS.index("elongation")] * model.uniform / per_kelvin
    first = {link: begun.p[joined.p.index[f"{link}.initial_temperature"]] for link in plant.links}
    mean = sum(share * first[owner] for owner, share in zip(owners, shares, strict=True) if owner in first)
    return round(float(mean - grown / per_kelvin), 9)


def _outputs(plant: Plant, slopes: Array) -> Array:
    """Rows of `OUTPUTS`: the temperatures that are read, 0 for those that are not, and the growth."""
    index = plant.component.y.index
    none = np.zeros(slopes.shape[1])
    read = [slopes[index[plant.read[name]]] if name in plant.read else none for name in OUTPUTS[:-1]]
    growth = sum((weight * slopes[index[name]] for name, weight in plant.growth.items()), none)
    return np.array([*read, growth])


def _heat_capacity(plant: Plant, at: Point) -> Array:
    """Heat capacity in J/K of each temperature at `ROOM_TEMPERATURE`, in the order of the states."""
    joined = plant.component
    assert joined.joint is not None
    settled = dict(zip(joined.d.names, joined.settled(at.p), strict=True))
    states = [name.rpartition(".") for name in joined.continuous.names if "temperature" in name]
    return np.array(
        [settled[f"{of}.{name.replace('temperature', 'heat_capacity')}"] for of, _, name in states]
    )


def _at_rest(plant: Plant, speed: float) -> Point:
    """Everything at room temperature, nothing heated; still air as at the rise for which it is stated."""
    joined = plant.component
    parts = ("initial_winding_temperature", "initial_shaft_temperature")
    starts = {f"{each}.{part}": ROOM_TEMPERATURE for each in plant.motors for part in parts}
    starts |= {f"{each}.initial_temperature": ROOM_TEMPERATURE for each in plant.links}
    inputs = dict.fromkeys(plant.surroundings, ROOM_TEMPERATURE)
    neighbours = [n for n in joined.u.names if n.endswith(".neighbour_temperature")]
    inputs |= dict.fromkeys(neighbours, ROOM_TEMPERATURE)
    inputs |= {f"{each}.speed": speed for each in (*plant.motors, *plant.links)}
    inputs |= {f"{each}.pad_mode": PAD_POWER for each in plant.motors}
    stated = {name: 0.0 for name in joined.p.names if name.endswith(".convection_rise_exponent")}
    given = {name: value for name, value in plant.given.items() if ".initial_" not in name}
    return start(joined, {**starts, **given, **inputs, **stated})
