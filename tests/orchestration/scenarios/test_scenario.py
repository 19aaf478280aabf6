from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.quantity import quantity
from warmlink.orchestration.scenarios.scenario import load_scenario, read_scenario, scenario_names

HOUR = "stop_time = '1 h'\n"

CELL = {"motor": MOTOR, "link": LINK}


def test_the_scenarios_that_the_paper_and_practice_ask_for_are_shipped() -> None:
    wanted = {"windshield_wiper", "paper_stationary", "paper_moving", "production_shift", "stop_and_go"}
    assert wanted <= set(scenario_names())


@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_reads_and_its_step_divides_its_time(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.title
    assert scenario.about
    assert scenario.stop_time / scenario.step_size == pytest.approx(
        round(scenario.stop_time / scenario.step_size)
    )


def test_the_default_is_two_hours_of_full_duty() -> None:
    scenario = load_scenario("windshield_wiper")
    segment = scenario.duty.segments[0]
    assert (scenario.stop_time, segment.speed, segment.torque) == (7200, 3.43, 2.5)
    assert segment.ambient_temperature == pytest.approx(295.15)


def test_the_pad_mode_follows_from_what_the_segment_gives() -> None:
    text = b"""
    stop_time = "3 min"
    [[segment]]
    duration = "1 min"
    [[segment]]
    duration = "1 min"
    pad_power = "20 W"
    [[segment]]
    duration = "1 min"
    pad_temperature = "36 degC"
    """
    duty = read_scenario("mine", text).duty
    assert [segment.pad_mode for segment in duty.segments] == [0, 1, 2]
    assert duty.component_parameters()["segment_pad_temperature[3]"] == pytest.approx(309.15)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("title = ", "not readable as TOML"),
        ("title = 'x'", "stop_time is missing"),
        ("stop_time = '1 h'", r"give either \[\[segment\]\] tables or one \[random\]"),
        ("colour = 1\n[[segment]]\nduration = '1 s'", "colour is not known"),
        (f"{HOUR}[[segment]]\nspeed = '1 rad/s'", "segment 1: duration is missing"),
        (f"{HOUR}[[segment]]\nduration = '0 s'", "segment 1.duration: 0 s is not positive"),
        (f"{HOUR}[[segment]]\nduration = '1 s'\nspede = 1", "segment 1: unknown entry 'spede'"),
        (f"{HOUR}[[segment]]\nduration = '1 s'\nspeed = '1 m'", "m does not convert to rad/s"),
        (f"{HOUR}[[segment]]\nduration = '1 s'\npad_power = 1\npad_temperature = 300", "exclude each other"),
        (f"{HOUR}segment = 3", "not a list of tables"),
        ("duty = 'nothing'", "nothing: no such duty cycle"),
        ("duty = 'continuous'\nrepeat = true", "repeat beside duty"),
        ("duty = 'continuous'\nparameters = 3", "parameters is not a table"),
    ],
)
def test_a_bad_scenario_is_refused_in_one_sentence(content: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as refusal:
        read_scenario("mine", content.encode())
    assert "\n" not in str(refusal.value)


def test_an_unknown_scenario_names_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="windshield_wiper"):
        load_scenario("windscreen")
    with pytest.raises(InputError, match="no such file"):
        load_scenario(str(tmp_path / "absent.toml"))


def test_start_values_are_converted_and_differences_know_that_they_are() -> None:
    values = start_values(
        {"link.length": "330 mm", "link.initial_temperature": "20 degC", "link.ambient_offset": "2 degC"},
        CELL,
        "mine",
    )
    assert values["link"]["length"] == pytest.approx(0.33)
    assert values["link"]["initial_temperature"] == pytest.approx(293.15)
    assert values["link"]["ambient_offset"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("arm.length", 1, "there is no component arm"),
        ("link.lenght", 1, "did you mean length"),
        ("link.length", "3 kg", "kg does not convert to m"),
        ("link.length", "3 furlnogs", "not a known unit"),
        ("link.length", "long", "is not a value"),
        ("link.length", "nan", "not a finite number"),
        ("link.width", "-20 mm", r"link.width: -0.02 m is not positive"),
        ("link.tip_position", "50 cm", "lies beyond the link's end"),
    ],
)
def test_a_bad_start_value_is_refused_in_one_sentence(name: str, value: object, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as refusal:
        start_values({name: value}, CELL, "mine")  # type: ignore[dict-item]
    assert "\n" not in str(refusal.value)


def test_a_bare_number_is_in_the_si_unit() -> None:
    assert quantity(2.5, "N.m", "torque") == 2.5
    assert quantity("2.5", "N.m", "torque") == 2.5
