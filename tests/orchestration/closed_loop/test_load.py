"""What a scenario file says of its duty cycle, and what it may not say of it."""

from __future__ import annotations

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import read_scenario

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
