"""Programs: what each joint of the arm is asked to do, and the poses in which the tool works.

A program is a TOML file with `title`, `reason`, `stop_time`, perhaps `repeat`, and `[[segment]]` tables or
one `[random]` table. A segment has `duration`, `speed` and `torque` of the six joints from the base
outwards, and `ambient_temperature`; what is left out is 0, or 22 degC. `[[pose]]` tables give the poses that
the arm goes through all the time: `hold`, and either `joints`, six angles, or `point`, the tool point's x, y
and z, with the tool's `pitch` above the horizontal and `roll`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.plant import INPUTS, OUTPUTS, Plant, cell_plant, plant_model
from warmlink.controllers.lag.component import COMPONENT as LAW
from warmlink.controllers.lag.fit import first_order
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.pose_sequence.equations import POSES
from warmlink.orchestration.arm import chain
from warmlink.orchestration.arm.chain import axis, axis_name
from warmlink.orchestration.arm.errors import ArmErrors
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.machine.machine import COMPENSATOR, Machine
from warmlink.orchestration.machine.roles import Roles, Sensors
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Drive, Duty, Segment
from warmlink.orchestration.scenarios.duties.duty_files import SHORTEST_DRAWN, Row, RowsTables, durations
from warmlink.orchestration.scenarios.mismatch import NOMINAL
from warmlink.orchestration.scenarios.scenario import Scenario, Settings
from warmlink.orchestration.system.model import StartValues, Value
from warmlink.orchestration.written.entries import Quantities, Quantity, Whole
from warmlink.orchestration.written.expression import Expression
from warmlink.orchestration.written.tables import Table, read_table

CONTROLLER, TOLERANCE = "observer", 30e-6
"""What the arm's scenarios have unless they say otherwise; the tolerance in m."""

STILL = (0.0,) * AXES

Pose = tuple[float, tuple[float, ...]]
"""Time in s for which six joint angles in rad are held, and these."""

OBSERVER, LAG = "observer", "lag"

SENSORS = Sensors(0.1, ("middle",))
"""One thermometer for each axis, half-way along its link, unless a scenario says otherwise."""

DESIGNED = ("none", LAG, OBSERVER)
"""Laws that have a design for any axis; the others come with the parameters of the warm-up cell."""

_FIT_TIME, _FIT_POINTS, _FIT_HEAT, _FIT_SPEED = 7200.0, 721, 20.0, 0.7
"""The lag law is fitted to two hours of 20 W in the shaft at 0.7 rad/s."""


@dataclass(frozen=True)
class Program(Drive):
    """A program of the arm: a duty cycle for each joint from the base outwards, and the poses gone through.

    `axes` is the number of axes that the arm has; beyond six the duty cycles begin again.
    """

    duties: tuple[Duty, ...]
    poses: tuple[Pose, ...]
    axes: int = AXES

    def start_values(self) -> StartValues:
        """Start values of the duty cycles and of the poses, by instance."""
        driven = {
            f"{axis_name(i)}.duty": self.duties[(i - 1) % AXES].component_parameters
            for i in range(1, self.axes + 1)
        }
        poses: dict[str, Value] = {"repeat": True}
        unused = (0.0, STILL)
        for i, (hold, angles) in enumerate([*self.poses, *[unused] * (POSES - len(self.poses))], start=1):
            poses[f"duration[{i}]"] = hold
            poses |= {f"joint_{joint}[{i}]": angle for joint, angle in enumerate(angles, start=1)}
        return {**driven, chain.POSES: poses}


@dataclass(frozen=True)
class JointsTable(Table):
    """Constant demands on the six joints from the base outwards."""

    most = 1

    duration: Annotated[float, Quantity("s", positive=True)]
    speed: Annotated[tuple[float, ...], Quantities("rad/s", AXES, 0)] = STILL
    torque: Annotated[tuple[float, ...], Quantities("N.m", AXES, 0)] = STILL
    ambient_temperature: Annotated[float, Quantity("K", least=0)] = ROOM_TEMPERATURE

    def rows(self, stop_time: float, where: str) -> Iterator[Row]:
        """The segment of each joint."""
        demands = zip(self.speed, self.torque, strict=True)
        yield tuple(Segment(self.duration, *each, self.ambient_temperature) for each in demands)


@dataclass(frozen=True)
class JobsTable(Table):
    """Jobs drawn evenly up to the largest speeds and torques, every so often a pause between them."""

    seed: Annotated[int, Whole(0, duty_files.MOST_SEED)]
    shortest: Annotated[float, Quantity("s", positive=True)]
    longest: Annotated[float, Quantity("s", positive=True)]
    speed: Annotated[tuple[float, ...], Quantities("rad/s", AXES, 0)] = STILL
    torque: Annotated[tuple[float, ...], Quantities("N.m", AXES, 0)] = STILL
    pause_share: Annotated[float, Quantity("1")] = 0.0

    def __post_init__(self) -> None:
        if not SHORTEST_DRAWN <= self.shortest <= self.longest:
            raise InputError(
                f"shortest: {self.shortest:g} s does not lie between {SHORTEST_DRAWN:g} s and longest "
                f"({self.longest:g} s); mend the bounds"
            )
        if not 0 <= self.pause_share <= 1:
            raise InputError(f'pause_share: {self.pause_share:g} is no share; give 0 to 1, as 0.2 or "20 %"')

    def rows(self, stop_time: float, where: str) -> Iterator[Row]:
        """Segments of each joint that are drawn until a stop time in s."""
        generator, lasting = np.random.default_rng(self.seed), (self.shortest, self.longest)
        for duration in durations(generator, lasting, stop_time, f"{where}.shortest"):
            shares = generator.uniform(size=(2, AXES)) * (generator.uniform() >= self.pause_share)
            drawn = zip(*shares, self.speed, self.torque, strict=True)
            yield tuple(
                Segment(duration, round(float(a * speed), 4), round(float(b * torque), 3))
                for a, b, speed, torque in drawn
            )


@dataclass(frozen=True)
class PoseTable(Table):
    """A pose that is held: six joint angles, or the tool's point with its pitch above the horizontal."""

    hold: Annotated[float, Quantity("s", positive=True)]
    joints: Annotated[tuple[float, ...] | None, Quantities("rad", AXES)] = None
    point: Annotated[tuple[float, ...] | None, Quantities("m", 3)] = None
    pitch: Annotated[float | None, Quantity("rad")] = None
    roll: Annotated[float | None, Quantity("rad")] = None

    def __post_init__(self) -> None:
        if (self.joints is None) == (self.point is None):
            raise InputError("give either joints or a point")
        for key in ("pitch", "roll"):
            if self.point is None and getattr(self, key) is not None:
                raise InputError(f"{key}: is of a point, and beside joints without effect; leave it out")

    def pose(self, where: str) -> Pose:
        """The pose as angles; raises InputError where the arm cannot take it."""
        angles, place = self.joints, "joints"
        if self.point is not None:
            x, y, z = self.point
            turns = self.pitch or 0.0, self.roll or 0.0
            angles, place = chain.reaching_angles(x, y, z, *turns)[0].tolist(), "point"
            if not np.all(np.isfinite(angles)):
                at = ", ".join(f"{1e3 * each:g}" for each in (x, y, z))
                raise InputError(
                    f"{where}.point: ({at}) mm at this pitch is out of the arm's reach; choose another"
                )
        assert angles is not None
        (beyond,) = chain.beyond_limits(np.array([angles]))
        for i in np.flatnonzero(beyond).tolist():
            joint, turn = axis(i + 1), np.degrees(angles[i])
            raise InputError(
                f"{where}.{place}: joint {i + 1} ({joint.name}) would turn to {turn:.4g} deg, beyond its "
                f"{np.degrees(joint.joint_limit):g} deg; choose another"
            )
        return self.hold, tuple(angles)


@dataclass(frozen=True, kw_only=True)
class ProgramFile(RowsTables, Settings):
    """A program of the six-axis arm: what each joint does, and the poses in which the tool works."""

    stop_time: Annotated[float, Quantity("s", positive=True)]
    pose: tuple[PoseTable, ...]
    segment: tuple[JointsTable, ...] = ()
    random: JobsTable | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.pose:
            raise InputError("there is no pose; write [[pose]] above each pose")
        if len(self.pose) > POSES:
            raise InputError(f"{len(self.pose)} poses are more than the {POSES} that fit; leave some out")

    def program(self, name: str) -> Program:
        """The program; raises InputError where it has too many segments, or a point is out of reach."""
        called = [f"{name}, joint {joint}" for joint in range(1, AXES + 1)]
        duties = self.duties(name, self.stop_time, called)
        poses = tuple(each.pose(f"{name}: pose {i}") for i, each in enumerate(self.pose, 1))
        return Program(name, duties[0].title, duties[0].reason, self.stop_time, duties, poses)


def scenario_of(given: Mapping[str, Any], name: str, folder: Path = Path()) -> Scenario:
    """Scenario of the arm from the tables of a file; raises InputError where something in them is wrong."""
    file = read_table(ProgramFile, given, name)
    program = file.program(name)
    default = Scenario(name, program.title, program.reason, program, arm())
    return file.applied(replace(default, controller=shipped(CONTROLLER), tolerance=TOLERANCE), folder)


def plant(number: int) -> Plant:
    """Nominal motor and link of an axis by itself, without the conductance to the link before it."""
    motor = {name: value for name, value in axis(number).motor.items() if name != "neighbour_conductance"}
    return cell_plant(motor, axis(number).link)


def designs(law: str, sensors: Sensors, count: int = AXES) -> StartValues | None:
    """Start values of the compensators by instance for a law's name; None where it has no design here.

    `sensors` says what noise a reading has, and which temperatures each axis measures.
    """
    if law not in DESIGNED:
        return None
    values: dict[str, dict[str, Value]] = {}
    for i in range(1, count + 1):
        number, compensator = (i - 1) % AXES + 1, f"{axis_name(i)}.{COMPENSATOR}"
        if law == OBSERVER:
            values[compensator] = dict(_observer(number, sensors.used or (), sensors.noise or 0.0))
        elif law == LAG:
            values[compensator] = dict(_lag(number))
    return values


@cache
def arm(count: int = AXES) -> Machine:
    """The arm, or one of another number of axes."""
    elongations = tuple(f"{axis_name(i)}.link.elongation" for i in range(1, count + 1))
    score = Expression(f"{chain.KINEMATICS}.error_norm")
    without = Expression(f"{chain.KINEMATICS}.uncompensated_error_norm", "uncompensated")
    return replace(
        chain.arm_chain(count),
        roles=Roles(score, without, elongations),
        nominal=chain.arm_values(count),
        sensors=SENSORS,
        designs=partial(designs, count=count),
        program=scenario_of,
        detail=_detail,
        laws=DESIGNED,
        mismatches=(NOMINAL,),
        sections="warmlink.orchestration.report.arm:sections",
        showcase="six_axis_shift",
    )


def _detail(result: Result) -> dict[str, Any]:
    return ArmErrors(result).to_dict()


@lru_cache(maxsize=64)
def _observer(number: int, used: tuple[str, ...], noise: float) -> dict[str, float]:
    """Observer of one axis by itself: what comes from its neighbours is unknown heat."""
    return by_scalar(design_controller(OBSERVER, used, noise, plant=plant(number)).parameters)


@lru_cache(maxsize=AXES)
def _lag(number: int) -> dict[str, float]:
    """Lag law of one axis by itself, fitted to the step response of its linear plant."""
    model = plant_model(plant(number))
    state, into = model.at(_FIT_SPEED)
    values, vectors = np.linalg.eig(state)
    weights = np.linalg.solve(vectors, into[:, INPUTS.index("shaft_heat")] * _FIT_HEAT)
    time = np.linspace(0.0, _FIT_TIME, _FIT_POINTS)
    rise = np.expm1(np.outer(time, values)) / values * weights
    growth = np.real(rise @ vectors.T @ model.C[OUTPUTS.index("elongation")])
    found = first_order(time, np.full_like(time, _FIT_HEAT), growth)
    motor = axis(number).motor
    losses = {name: motor[name] for name in LAW.p.index if name in motor}
    return {"gain": found.gain, "time_constant": found.time_constant, **losses}
