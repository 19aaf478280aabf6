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
from typing import Any

import numpy as np

from warmlink.fmus.component.quantities import ROOM_TEMPERATURE
from warmlink.fmus.errors import InputError
from warmlink.fmus.pose_sequence.equations import AXES, POSES
from warmlink.orchestration.arm.blueprint import POSES as POSE_SEQUENCE
from warmlink.orchestration.arm.blueprint import axis_name
from warmlink.orchestration.arm.inverse import joint_angles
from warmlink.orchestration.scenarios.duties.duty import Duty, Segment
from warmlink.orchestration.scenarios.duties.duty_files import MOST_SEED, SHORTEST_DRAWN
from warmlink.orchestration.scenarios.extent import check_segments
from warmlink.orchestration.scenarios.quantity import positive, quantity
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.text_files import (
    flag_entry,
    known_entries,
    shown,
    text_entry,
    whole_entry,
)

KEYS = {"title", "reason", "stop_time", "repeat", "segment", "random", "pose"}


@dataclass(frozen=True)
class Pose:
    """Six joint angles in rad, held for a time in s."""

    hold: float
    angles: tuple[float, ...]


@dataclass(frozen=True)
class Program:
    """A program of the arm.

    Attributes
    ----------
    duties : duty cycle of each joint, from the base outwards
    poses : gone through one after another, again and again
    axes : number of axes that the arm has; beyond six the duty cycles begin again
    """

    name: str
    title: str
    reason: str
    stop_time: float
    duties: tuple[Duty, ...]
    poses: tuple[Pose, ...]
    axes: int = AXES

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was taken for granted where a file did not say it."""
        return tuple(remark for duty in self.duties for remark in duty.remarks)

    def until(self, stop_time: float) -> Program:
        """The same with another stop time in s."""
        return replace(self, stop_time=stop_time)

    def start_values(self) -> dict[str, dict[str, Value]]:
        """Start values of the duty cycles and of the poses, by instance."""
        values: dict[str, dict[str, Value]] = {
            f"{axis_name(i)}.duty": dict(self.duties[(i - 1) % AXES].component_parameters())
            for i in range(1, self.axes + 1)
        }
        poses: dict[str, Value] = {"repeat": True}
        for i in range(POSES):
            pose = self.poses[i] if i < len(self.poses) else Pose(0.0, (0.0,) * AXES)
            poses[f"duration[{i + 1}]"] = pose.hold
            for joint, angle in enumerate(pose.angles, start=1):
                poses[f"joint_{joint}[{i + 1}]"] = angle
        return {**values, POSE_SEQUENCE: poses}


def parsed(given: Mapping[str, Any], name: str) -> Program:
    """Program from the tables of a file.

    Raises
    ------
    InputError
        Something is missing, misspelt, out of range, or a point is out of the arm's reach.
    """
    known_entries(given, KEYS, name)
    stop_time = positive(_required(given, "stop_time", name), "s", f"{name}.stop_time")
    if ("segment" in given) == ("random" in given):
        raise InputError(f"{name}: give either [[segment]] tables or one [random] table")
    if "random" in given:
        rows = list(_drawn(given["random"], stop_time, f"{name}: random"))
    else:
        rows = [
            _segment(table, f"{name}: segment {i}")
            for i, table in enumerate(_tables(given, "segment", name), 1)
        ]
    title, reason = text_entry(given, "title", name, name), text_entry(given, "reason", "", name).strip()
    repeat = flag_entry(given, "repeat", False, name)
    duties = tuple(
        Duty(
            f"{name}, joint {joint + 1}", title, reason, stop_time, tuple(row[joint] for row in rows), repeat
        )
        for joint in range(AXES)
    )
    poses = tuple(
        _pose(table, f"{name}: pose {i}") for i, table in enumerate(_tables(given, "pose", name), 1)
    )
    if len(poses) > POSES:
        raise InputError(f"{name}: {len(poses)} poses are more than the {POSES} that fit; leave some out")
    return Program(name, title, reason, stop_time, duties, poses)


def _segment(table: Mapping[str, Any], where: str) -> tuple[Segment, ...]:
    known_entries(table, {"duration", "speed", "torque", "ambient_temperature"}, where)
    duration = positive(_required(table, "duration", where), "s", f"{where}.duration")
    speed, torque = _six(table, "speed", "rad/s", where), _six(table, "torque", "N.m", where)
    ambient = quantity(
        table.get("ambient_temperature", ROOM_TEMPERATURE), "K", f"{where}.ambient_temperature"
    )
    return tuple(Segment(duration, speed[j], torque[j], ambient) for j in range(AXES))


def _pose(table: Mapping[str, Any], where: str) -> Pose:
    known_entries(table, {"hold", "joints", "point", "pitch", "roll"}, where)
    hold = positive(_required(table, "hold", where), "s", f"{where}.hold")
    if ("joints" in table) == ("point" in table):
        raise InputError(f"{where}: give either joints or a point")
    if "joints" in table:
        return Pose(hold, tuple(_listed(table["joints"], AXES, "rad", f"{where}.joints")))
    x, y, z = _listed(table["point"], 3, "m", f"{where}.point")
    pitch, roll = (quantity(table.get(key, 0.0), "rad", f"{where}.{key}") for key in ("pitch", "roll"))
    (angles,) = joint_angles(x, y, z, pitch, roll)
    if not np.all(np.isfinite(angles)):
        at = ", ".join(f"{1e3 * each:g}" for each in (x, y, z))
        raise InputError(f"{where}.point: ({at}) mm at this pitch is out of the arm's reach; choose another")
    return Pose(hold, tuple(float(angle) for angle in angles))


def _drawn(table: Mapping[str, Any], stop_time: float, where: str) -> Iterator[tuple[Segment, ...]]:
    """Jobs drawn evenly up to the largest speeds and torques, every so often a pause between them."""
    known_entries(table, {"seed", "shortest", "longest", "speed", "torque", "pause_share"}, where)
    seed = whole_entry(table.get("seed"), 0, MOST_SEED, f"{where}.seed")
    shortest, longest = (
        positive(_required(table, key, where), "s", f"{where}.{key}") for key in ("shortest", "longest")
    )
    if not SHORTEST_DRAWN <= shortest <= longest:
        raise InputError(
            f"{where}.shortest: {shortest:g} s does not lie between {SHORTEST_DRAWN:g} s and longest "
            f"({longest:g} s); mend the bounds"
        )
    check_segments(stop_time / shortest, f"{where}.shortest")
    speed, torque = _six(table, "speed", "rad/s", where), _six(table, "torque", "N.m", where)
    pause = quantity(table.get("pause_share", 0.0), "1", f"{where}.pause_share")
    generator = np.random.default_rng(seed)
    time = 0.0
    while time < stop_time:
        # Whole seconds, so that the segments fall on communication points.
        duration = float(round(generator.uniform(shortest, longest)))
        shares = generator.uniform(size=(2, AXES)) * (generator.uniform() >= pause)
        yield tuple(
            Segment(
                duration, round(float(shares[0, j] * speed[j]), 4), round(float(shares[1, j] * torque[j]), 3)
            )
            for j in range(AXES)
        )
        time += duration


def _six(table: Mapping[str, Any], key: str, unit: str, where: str) -> list[float]:
    values = _listed(table.get(key, [0.0] * AXES), AXES, unit, f"{where}.{key}")
    for joint, value in enumerate(values, start=1):
        if value < 0:
            raise InputError(f"{where}.{key}: {value:g} {unit} at joint {joint} is negative; give 0 or above")
    return values


def _listed(values: Any, count: int, unit: str, where: str) -> list[float]:
    if not isinstance(values, list) or len(values) != count:
        raise InputError(
            f"{where}: {shown(values)} is no list of {count}; give {count} values with their units"
        )
    return [quantity(each, unit, f"{where}[{i}]") for i, each in enumerate(values, start=1)]


def _tables(given: Mapping[str, Any], key: str, name: str) -> list[Mapping[str, Any]]:
    entries = given.get(key)
    if not isinstance(entries, list) or not entries or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{name}: {key} is not a list of tables; write [[{key}]] above each")
    return entries


def _required(table: Mapping[str, Any], key: str, where: str) -> Any:
    if key not in table:
        raise InputError(f"{where}: {key} is missing; add it with its unit")
    return table[key]
