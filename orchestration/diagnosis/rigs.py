"""The systems that measurements may come from: components, wires, and which sensor reads what.

A rig is the plant part of a shipped system, as the diagnosis integrates it in one piece. The names in it
are those of the SSP: instance, dot, variable.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property

from warmlink.controllers.interface import SENSED
from warmlink.fmus.errors import InputError
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.component import Component, Scalar
from warmlink.fmus.packaging.join import join
from warmlink.fmus.plant import ROD_WIRES, plant
from warmlink.fmus.thermal_link.component import thermal_link

ELONGATION = "link.elongation"


@dataclass(frozen=True)
class Rig:
    """A plant to be integrated as a whole.

    Attributes
    ----------
    component : the plant, joined
    shared : inputs that one signal feeds unless told otherwise, as the ambient temperature of all
    columns : signal or output for each column of a bare CSV file
    readings : sensor channel that reads an output, as `sensors[3]`; the camera reads the elongation
    driven_by : inputs that every run should have, each with those that may stand in its place
    """

    name: str
    component: Component
    shared: tuple[tuple[str, ...], ...]
    columns: Mapping[str, str]
    readings: Mapping[str, str]
    driven_by: tuple[tuple[str, ...], ...]

    @cached_property
    def components(self) -> Mapping[str, Component]:
        """Declarations by instance name."""
        assert self.component.joint is not None
        return self.component.joint.parts

    @cached_property
    def variables(self) -> dict[str, Scalar]:
        """Every scalar variable by its full name; inputs that a component feeds are none."""
        return {scalar.name: scalar for scalar in self.component.scalars()}

    @property
    def externals(self) -> list[str]:
        """Inputs that no component feeds, in order."""
        return self.component.u.names

    @property
    def parameters(self) -> list[str]:
        """Parameters of all components, in order."""
        return self.component.p.names

    def scalar(self, name: str, where: str) -> Scalar:
        """Declaration of a variable.

        Raises
        ------
        InputError
            The rig has no such variable.
        """
        if name not in self.variables:
            instance = name.partition(".")[0]
            held = [n for n in self.variables if n.startswith(f"{instance}.")]
            raise InputError(
                f"{where}: {self.name} has no variable {name}; {instead(name, held or self.variables)}"
            )
        return self.variables[name]

    def column_of(self, variable: str) -> str:
        """Name of a variable's column in a bare CSV file; its own where there is none."""
        return next((column for column, named in self.columns.items() if named == variable), variable)

    def fed_with(self, name: str) -> tuple[str, ...]:
        """Inputs that a signal for this input feeds when nothing else is said."""
        return next((group for group in self.shared if name in group), (name,))

    def readings_of(self, variable: str) -> str | None:
        """Sensor or camera that reads an output."""
        return self.readings.get(variable)


_DEMANDS = (
    ("motor.speed",),
    ("motor.torque", "motor.current"),
    ("motor.pad_temperature", "motor.pad_power"),
    ("motor.ambient_temperature",),
)

_MIDDLE = "link.sensor_temperature[2]"
_TEMPERATURES = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    _MIDDLE,
    "link.tip_temperature",
)


def warmup_cell(cells: int = 40) -> Rig:
    """Motor and link, the cell of the paper."""
    ambient = ("motor.ambient_temperature", "link.ambient_temperature", "link.tip_sink_temperature")
    return Rig(
        "WarmupCell",
        plant(cells),
        (ambient, ("motor.speed", "link.speed")),
        {
            "speed": "motor.speed",
            "torque": "motor.torque",
            "pad_temperature": "motor.pad_temperature",
            "ambient_temperature": "motor.ambient_temperature",
            **dict(zip(SENSED, _TEMPERATURES, strict=True)),
            "elongation": ELONGATION,
        },
        {
            **{variable: f"sensors[{i + 1}]" for i, variable in enumerate(_TEMPERATURES)},
            ELONGATION: "camera",
        },
        _DEMANDS,
    )


def bench_rod(cells: int = 40) -> Rig:
    """A heater on a plain rod."""
    sensors = [f"link.sensor_temperature[{i}]" for i in range(1, 9)]
    return Rig(
        "BenchRod",
        join("BenchRod", {"heater": HEATER, "link": thermal_link(cells)}, ROD_WIRES),
        (("link.ambient_temperature", "link.tip_sink_temperature"),),
        {},
        {
            **{variable: f"sensors[{i + 1}]" for i, variable in enumerate(sensors)},
            "link.base_temperature": "sensors[1]",
            "link.tip_temperature": "sensors[3]",
            ELONGATION: "camera",
        },
        (("heater.on",), ("link.ambient_temperature",)),
    )


def bench_motor(cells: int = 0) -> Rig:
    """A motor by itself; `cells` is there for the sake of a common form."""
    return Rig(
        "BenchMotor",
        join("BenchMotor", {"motor": MOTOR}),
        (),
        {},
        {"motor.shaft_temperature": "sensors[1]", "motor.winding_temperature": "sensors[2]"},
        _DEMANDS,
    )


RIGS = {"WarmupCell": warmup_cell, "BenchRod": bench_rod, "BenchMotor": bench_motor}


@cache
def rig(name: str, cells: int = 40) -> Rig:
    """Rig of a shipped system by name.

    Raises
    ------
    InputError
        There is no such system.
    """
    if name not in RIGS:
        raise InputError(f"system: {name!r} is not one that can be diagnosed; {instead(name, RIGS)}")
    return RIGS[name](cells)
