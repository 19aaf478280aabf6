"""Scenarios of the arm: a program, and how it is run and compensated.

The file of a program is a scenario of the arm where it says `system = "SixAxisArm"`. It may also have
`step_size`, `master`, `controller`, `tolerance`, `sensor` (which of the axis's thermometers there is: shaft,
winding, base, middle or tip), `sensor_noise`, and a table `parameters`, as `"axis2.motor.joint_conductance"`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warmlink.controllers.interface import SENSED
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.pose_sequence.equations import AXES
from warmlink.orchestration.arm import program as programs
from warmlink.orchestration.arm.library import PROGRAMS, SYSTEM, arm_scenario_names, table_of
from warmlink.orchestration.arm.program import Program
from warmlink.orchestration.scenarios.extent import MOST_POINTS, check_extent
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.scenario import DEFAULT_MASTER, DEFAULT_STEP, written_parameters
from warmlink.orchestration.text_files import text_entry

SENSORS = tuple(name.removesuffix("_temperature") for name in SENSED)

DEFAULT_CONTROLLER = "observer"
DEFAULT_TOLERANCE = 30e-6
DEFAULT_SENSOR = "middle"
DEFAULT_NOISE = 0.1

_SETTINGS = {
    SYSTEM,
    "step_size",
    "master",
    "controller",
    "tolerance",
    "sensor",
    "sensor_noise",
    "parameters",
}


@dataclass(frozen=True)
class ArmScenario:
    """What to run: the step in s, the tolerance in m, the noise of a reading in K (1 sigma).

    `parameters` holds start values as written, `"2 W/K"` under `axis2.motor.joint_conductance`: what the
    plant has and its observers do not know of.
    """

    program: Program
    step_size: float = DEFAULT_STEP
    master: str = DEFAULT_MASTER
    controller: str = DEFAULT_CONTROLLER
    tolerance: float = DEFAULT_TOLERANCE
    sensor: str = DEFAULT_SENSOR
    sensor_noise: float = DEFAULT_NOISE
    parameters: dict[str, str | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_extent(self.name, self.stop_time, self.step_size, MOST_POINTS // AXES)

    @property
    def name(self) -> str:
        """Name of the program."""
        return self.program.name

    @property
    def title(self) -> str:
        """Title of the program."""
        return self.program.title

    @property
    def stop_time(self) -> float:
        """Stop time in s."""
        return self.program.stop_time

    @property
    def sensor_channel(self) -> int:
        """Channel of TemperatureSensors that the axis's one thermometer is."""
        return SENSORS.index(self.sensor) + 1


def load_arm_scenario(name: str) -> ArmScenario:
    """Scenario of the arm by its name, or by the path of a TOML file.

    Raises
    ------
    InputError
        If there is none, or the file does not hold one.
    """
    shipped = PROGRAMS / f"{name}.toml"
    path = shipped if name in arm_scenario_names() else Path(name)
    table = table_of(path)
    if not table:
        raise InputError(f"{name}: no such scenario of the arm; {instead(name, arm_scenario_names())}")
    return read_arm_scenario(path.stem, table)


def read_arm_scenario(name: str, table: Mapping[str, Any]) -> ArmScenario:
    """Scenario from the tables of its file."""
    sensor = text_entry(table, "sensor", DEFAULT_SENSOR, name)
    if sensor not in SENSORS:
        raise InputError(f"{name}: sensor {sensor!r} is none of the axis's; {instead(sensor, SENSORS)}")
    own = {key: value for key, value in table.items() if key not in _SETTINGS}
    return ArmScenario(
        program=programs.parsed(own, name),
        step_size=positive(table.get("step_size", DEFAULT_STEP), "s", f"{name}: step_size"),
        master=text_entry(table, "master", DEFAULT_MASTER, name),
        controller=text_entry(table, "controller", DEFAULT_CONTROLLER, name),
        tolerance=positive(table.get("tolerance", DEFAULT_TOLERANCE), "m", f"{name}: tolerance"),
        sensor=sensor,
        sensor_noise=positive(table.get("sensor_noise", DEFAULT_NOISE), "K", f"{name}: sensor_noise"),
        parameters=written_parameters(name, table),
    )
