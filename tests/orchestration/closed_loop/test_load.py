"""What a scenario file says of its duty cycle, and what it may not say of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario

SEGMENTS = 'stop_time = "1 h"\ntitle = "Mine"\n[[segment]]\nduration = "1 h"\nspeed = "1 rad/s"\n'


def test_a_named_duty_cycle_is_told_beside_the_scenario_and_a_written_one_is_the_scenario() -> None:
    named = read_scenario("mine", 'duty = "windshield_wiper"')
    assert named.title.startswith("mine · ")
    assert named.about.startswith("Duty cycle windshield_wiper: ")
    written = read_scenario("mine", SEGMENTS)
    assert written.title == "Mine"
    assert "Duty cycle" not in written.about


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ('linear = ["ambient_temperature"]\n', "linear: is of a recorded duty; name one"),
        ('[columns]\nT = "ambient_temperature"\n', "columns: is of a recorded duty; name one"),
    ],
)
def test_what_a_recording_alone_has_is_refused_beside_segments(more: str, told: str) -> None:
    text = f"{more}{SEGMENTS}" if "linear" in more else f"{SEGMENTS}{more}"
    with pytest.raises(InputError, match=told):
        read_scenario("mine", text)


def test_a_reason_beside_the_name_of_a_duty_cycle_is_refused() -> None:
    """It had no effect: the duty cycle has its own."""
    with pytest.raises(InputError, match="reason beside duty; name a duty cycle or write one, not both"):
        read_scenario("mine", 'duty = "windshield_wiper"\nreason = "mine"')


def test_endings_in_capitals_are_read_alike(tmp_path: Path) -> None:
    (tmp_path / "MINE.TOML").write_text(SEGMENTS)
    (tmp_path / "LOGGED.CSV").write_text("time [s],speed [rad/s],torque [N.m]\n0,1,1\n600,2,1\n1200,0,0\n")
    assert load_scenario(str(tmp_path / "MINE.TOML")).title == "Mine"
    assert load_scenario(str(tmp_path / "LOGGED.CSV")).stop_time == 1200.0
    (tmp_path / "named.toml").write_text('duty = "LOGGED.CSV"\n')
    assert load_scenario(str(tmp_path / "named.toml")).stop_time == 1200.0
