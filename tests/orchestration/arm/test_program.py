"""Programs of the arm and the inverse kinematics that their points go through."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.fmus.arm_kinematics.component import COMPONENT as KINEMATICS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.chain import axes, joint_angles
from warmlink.orchestration.arm.program import Program, ProgramFile
from warmlink.orchestration.closed_loop.load import names_on, of_tables
from warmlink.orchestration.written.tables import read_table

from .conftest import load_program


def tool_point(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nominal tool point and direction of the tool, by the component itself."""
    p = KINEMATICS.settled(np.array([s.start for s in KINEMATICS.scalars()][: KINEMATICS.p.size]))
    u = np.zeros(KINEMATICS.u.size)
    u[:6] = angles
    y = KINEMATICS.y.read(KINEMATICS.outputs_of(np.zeros(0), u, p, 0.0))
    tool = np.array([y.sensitivity_x[5], y.sensitivity_y[5], y.sensitivity_z[5]])
    return np.asarray(y.nominal_position), tool


@given(st.floats(0.38, 0.55), st.floats(-3.0, 3.0), st.floats(0.05, 0.3), st.floats(-1.6, -1.0))
def test_the_angles_bring_the_tool_point_there(out: float, turn: float, up: float, pitch: float) -> None:
    x, y = out * np.cos(turn), out * np.sin(turn)
    (angles,) = joint_angles(x, y, up, pitch)
    if np.any(np.isnan(angles)):
        return
    point, tool = tool_point(angles)
    assert point == pytest.approx([x, y, up], abs=1e-12)
    assert tool == pytest.approx(
        [np.cos(pitch) * np.cos(turn), np.cos(pitch) * np.sin(turn), np.sin(pitch)], abs=1e-12
    )


def test_what_is_out_of_reach_has_no_angles() -> None:
    assert np.all(np.isnan(joint_angles(1.5, 0.0, 0.3, -np.pi / 2)))
    assert np.all(np.isnan(joint_angles(0.05, 0.0, 0.3, -np.pi / 2)))
    assert np.all(np.isfinite(joint_angles(0.45, 0.0, 0.15, -np.pi / 2)))


@pytest.mark.parametrize("name", names_on("SixAxisArm"))
def test_every_program_fits_the_components_and_the_limits(name: str) -> None:
    program = load_program(name)
    assert program.title
    assert program.reason
    limits = np.array([each.joint_limit for each in axes()])
    for _, angles in program.poses:
        assert np.all(np.abs(angles) <= limits)
    for axis in range(1, 7):
        assert len(program.start_values()[f"axis{axis}.duty"]) == 1 + 32 * 7
    lasting = sum(segment.duration for segment in program.duties[0].segments)
    assert program.duties[0].repeat or lasting >= 0.95 * program.stop_time
    assert any(segment.speed > 0 for duty in program.duties for segment in duty.segments)


def test_the_programs_that_were_asked_for_are_there() -> None:
    kinds = (
        "palletising",
        "welding",
        "inspection",
        "iso_9283",
        "warm_up",
        "lunch_break",
        "random_jobs",
        "shift",
    )
    assert set(names_on("SixAxisArm")) == {f"six_axis_{kind}" for kind in kinds}


def test_random_jobs_repeat_with_their_seed() -> None:
    assert load_program("six_axis_random_jobs") == load_program("six_axis_random_jobs")


def parsed(given: dict[str, Any], name: str) -> Program:
    return read_table(ProgramFile, given, name).program(name)


GOOD: dict[str, Any] = {
    "stop_time": "1 h",
    "segment": [{"duration": "1 h", "speed": ["1 rad/s"] * 6}],
    "pose": [{"hold": "1 s", "joints": ["0 deg"] * 6}],
}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"segment": [{"duration": "1 h", "speed": ["1 rad/s"] * 5}]}, "no list of 6"),
        (
            {"segment": [{"duration": "1 h", "speed": ["-1 rad/s"] * 6}]},
            r"speed: value 1: -1 rad/s is negative",
        ),
        ({"segment": [{"speed": ["1 rad/s"] * 6}]}, "duration is missing"),
        ({"pose": []}, r"write \[\[pose\]\] above each"),
        ({"pose": [{"hold": "1 s", "point": ["2 m", "0 m", "0 m"]}]}, "out of the arm's reach"),
        (
            {"pose": [{"hold": "1 s", "point": ["450 mm", "0 m", "200 mm"], "pitch": "-60 deg"}]},
            r"pose 1.point: joint 3 \(elbow\) would turn to -114.7 deg, beyond its 110 deg; choose another",
        ),
        (
            {"pose": [GOOD["pose"][0], {"hold": "1 s", "joints": ["0 deg", "91 deg", *["0 deg"] * 4]}]},
            r"pose 2.joints: joint 2 \(shoulder\) would turn to 91 deg, beyond its 90 deg; choose another",
        ),
        ({"pose": [{"hold": "1 s"}]}, "either joints or a point"),
        (
            {"pose": [{**GOOD["pose"][0], "roll": "400 deg"}]},
            "roll: is of a point, and beside joints without",
        ),
        ({"pose": [{**GOOD["pose"][0], "pitch": "0 deg"}]}, "pitch: is of a point"),
        ({"pose": GOOD["pose"] * 33}, "33 poses are more than the 32"),
        ({"stop_time": "-1 h"}, "not positive"),
        ({"speed": 3}, "speed is not known"),
        ({"random": {"seed": 1, "shortest": "5 min", "longest": "9 min"}}, "either"),
        ({"repeat": "false"}, "repeat: 'false' is neither true nor false"),
        ({"title": 3}, "title: 3 is no text"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], sentence: str) -> None:
    assert parsed(GOOD, "mine").duties[5].segments[0].speed == 1
    with pytest.raises(InputError, match=sentence):
        parsed({**GOOD, **change}, "mine")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"shortest": "0.1 s"}, "shortest: 0.1 s does not lie between 1 s and longest"),
        ({"seed": True}, "seed: true is not a whole number"),
        ({"pause_share": 20}, 'pause_share: 20 is no share; give 0 to 1, as 0.2 or "20 %"'),
        ({"pause_share": -3}, "pause_share: -3 is no share"),
        (
            {"shortest": "40.4 s", "longest": "40.6 s"},
            r"random\.shortest: there is no whole number of seconds between 40\.4 s and 40\.6 s",
        ),
    ],
)
def test_jobs_that_cannot_be_drawn_are_refused(change: dict[str, Any], sentence: str) -> None:
    drawn = {"seed": 1, "shortest": "5 min", "longest": "20 min"}
    given = {"stop_time": "1 h", "pose": GOOD["pose"]}
    assert parsed({**given, "random": drawn}, "mine").duties
    with pytest.raises(InputError, match=sentence):
        parsed({**given, "random": {**drawn, **change}}, "mine")


def test_jobs_last_whole_seconds_between_their_bounds() -> None:
    """They were rounded after they were drawn: 40.4 s gave jobs of 40 s."""
    drawn = {"seed": 1, "shortest": "40.4 s", "longest": "43.6 s", "pause_share": "20 %"}
    given = {"stop_time": "20 min", "pose": GOOD["pose"], "random": drawn}
    lasting = {segment.duration for segment in parsed(given, "mine").duties[0].segments}
    assert lasting == {41.0, 42.0, 43.0}


@pytest.mark.parametrize("key", ["step_size", "master", "controller", "tolerance", "sensors", "parameters"])
@pytest.mark.parametrize("wrong", [True, [], {"a": {"b": 1}}, 10**400, float("nan"), None])
def test_a_wrong_type_of_a_setting_gives_a_sentence(key: str, wrong: object) -> None:
    with pytest.raises(InputError, match=r"^mine: ") as refusal:
        of_tables("mine", {"system": "SixAxisArm", **GOOD, key: wrong})
    assert len(str(refusal.value)) < 300
