"""Motor and link joined: the plant whose growth is to be compensated."""

from functools import cache

from warmlink.fmus.component import Component
from warmlink.fmus.component.join import Wire, join
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.component.reference import Phase
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import CELLS, thermal_link

WIRES: tuple[Wire, ...] = (
    ("motor.heat_flow", "link.heat_flow"),
    ("link.base_temperature", "motor.link_base_temperature"),
)
"""Wires between a motor and the link on its shaft."""

ROD_WIRES: tuple[Wire, ...] = (
    ("heater.heat_flow", "link.heat_flow"),
    ("link.base_temperature", "heater.link_base_temperature"),
)
"""Wires between a heater and the link that it heats."""


@cache
def plant(cells: int = CELLS) -> Component:
    """Motor and link as one component; `cells` is the number of the link's finite volumes."""
    return join("Plant", {"motor": MOTOR, "link": thermal_link(cells)}, WIRES, "Motor and link in one piece")


def demand(
    duration: float, speed: float, torque: float, ambient_temperature: float = ROOM_TEMPERATURE
) -> Phase:
    """Phase of the plant: duration in s, speed in rad/s, torque in N.m, temperature in K."""
    return Phase(
        duration,
        {
            "motor.speed": speed,
            "link.speed": speed,
            "motor.torque": torque,
            "motor.ambient_temperature": ambient_temperature,
            "link.ambient_temperature": ambient_temperature,
        },
    )
