import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.duty_cycle.component import COMPONENT as DUTY
from warmlink.fmus.errors import InputError
from warmlink.fmus.motor_heat_source.component import COMPONENT as MOTOR
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS
from warmlink.fmus.thermal_link.component import COMPONENT as LINK
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario, scenario_names
from warmlink.orchestration.scenarios.overrides import start_values
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.written.quantities import quantity

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
    text = """
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
    assert duty.component_parameters["segment_pad_temperature[3]"] == pytest.approx(309.15)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("title = ", "not readable as TOML"),
        ("title = 'x'", "stop_time is missing"),
        ("stop_time = '1 h'", r"give either \[\[segment\]\] tables or one \[random\]"),
        ("colour = 1\n[[segment]]\nduration = '1 s'", "colour is not known"),
        (f"{HOUR}[[segment]]\nspeed = '1 rad/s'", "segment 1: duration is missing"),
        (f"{HOUR}[[segment]]\nduration = '0 s'", "segment 1.duration: 0 s is not positive"),
        (
            f"{HOUR}[[segment]]\nduration = '1 s'\nspede = 1",
            "spede is not known; did you mean speed",
        ),
        (f"{HOUR}[[segment]]\nduration = '1 s'\nspeed = '1 m'", "m does not convert to rad/s"),
        (f"{HOUR}[[segment]]\nduration = '1 s'\npad_power = 1\npad_temperature = 300", "exclude each other"),
        (f"{HOUR}segment = 3", "not a list of tables"),
        ("duty = 'nothing'", "nothing: no such duty cycle"),
        ("duty = 'continuous'\nrepeat = true", "repeat beside duty"),
        ("duty = 'continuous'\nparameters = 3", "parameters: 3 is not a table"),
    ],
)
def test_a_bad_scenario_is_refused_in_one_sentence(content: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as refusal:
        read_scenario("mine", content)
    assert "\n" not in str(refusal.value)


def test_what_python_cannot_write_out_is_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="stop_time: a number beyond 64 bits"):
        read_scenario("mine", f"duty = 'continuous'\nstop_time = 0x{'F' * 5000}")
    with pytest.raises(InputError, match="a is not known"):
        read_scenario("mine", f"duty = 'continuous'\n{'a.' * 3000}b = 1")


WRONG = ("3", "-1.5", "true", "'words'", "[]", "[1]", "{}", "{ a = 1 }", "nan", "1979-05-27", "9" * 400, "''")
WHOLE = """
title = 'x'
about = 'x'
reason = 'x'
stop_time = '2 h'
repeat = true
step_size = '1 s'
master = 'jacobi'
controller = 'lag'
tolerance = '5 um'
"""
SEGMENT = """
[[segment]]
duration = '1 h'
speed = '1 rad/s'
torque = '1 N.m'
ambient_temperature = '20 degC'
ambient_temperature_end = '30 degC'
steps = 3
pad_temperature = '30 degC'
"""
RANDOM = """
[random]
seed = 3
duration = ['5 min', '20 min']
speed = ['0 rad/s', '3 rad/s']
torque = ['0 N.m', '3 N.m']
"""
OWN_DUTY = "[parameters]\n'link.length' = '500 mm'\n"
FILES = (WHOLE + SEGMENT, WHOLE + RANDOM, "duty = 'continuous'\n" + OWN_DUTY)


def keys_of(text: str) -> list[str]:
    return [line.partition(" = ")[0] for line in text.splitlines() if " = " in line]


@pytest.mark.parametrize("text", FILES, ids=["segment", "random", "duty"])
def test_a_wrong_type_of_any_entry_gives_a_scenario_or_a_sentence(text: str) -> None:
    # The sentence names the entry, so that one finds the place.
    refused = 0
    for key in keys_of(text):
        for wrong in WRONG:
            lines = [
                f"{key} = {wrong}" if each.startswith(f"{key} =") else each for each in text.splitlines()
            ]
            try:
                scenario = read_scenario("mine", "\n".join(lines))
                components = {"link": LINK, "motor": MOTOR}
                start_values(scenario.parameters, components, scenario.name)
            except InputError as refusal:
                refused += 1
                sentence = str(refusal)
                assert "\n" not in sentence
                assert len(sentence) < 400, f"{key} = {wrong}"
                assert key.strip("'") in sentence or wrong.strip("'") in sentence, (
                    f"{key} = {wrong}: {sentence}"
                )
    assert refused > 5 * len(keys_of(text))


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ("title = 3", "title: 3 is no text"),
        ("repeat = 'false'", "repeat: 'false' is neither true nor false"),
        ("master = ['jacobi']", "master: a list is no text"),
        ("controller = 1", "controller: 1 is no text"),
        (
            "parameters = { link = { length = '1 m' } }",
            'put the whole name in quotes, as "link.length"',
        ),
        ("stop_time = 99999999999999999999", "a number beyond 64 bits is not a value"),
    ],
)
def test_what_was_taken_for_something_else_is_refused(entry: str, sentence: str) -> None:
    hour = "" if entry.startswith("stop_time") else HOUR
    with pytest.raises(InputError, match=sentence):
        read_scenario("mine", f"{entry}\n{hour}[[segment]]\nduration = '1 h'")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"stop_time": 1e20}, r"1e\+20 s is more than a year"),
        ({"step_size": 1e-3}, r"are 3.6e\+06 communication points, and a run keeps at most 1000000"),
    ],
)
def test_a_run_that_is_too_long_is_refused_but_not_the_duty_cycle(
    change: dict[str, float], sentence: str
) -> None:
    duty = replace(load_scenario("windshield_wiper").duty, stop_time=change.get("stop_time", 3600.0))
    scenario = Scenario("mine", "", "", duty, step_size=change.get("step_size", 1.0))
    with pytest.raises(InputError, match=sentence):
        scenario.values()
    replace(scenario, duty=replace(duty, stop_time=2.0)).values()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("['5 min', '20 min']", "['0.1 s', '0.4 s']"), "give bounds of at least 1 s"),
        (("'2 h'", "'1e12 s'"), "makes up to 3.33e\\+09 segments, and 100000 are the most"),
        (("seed = 3", "seed = true"), "seed: true is not a whole number"),
    ],
)
def test_segments_that_could_be_drawn_for_ever_are_refused(change: tuple[str, str], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        read_scenario("mine", (WHOLE + RANDOM).replace(*change))


def test_a_ramp_has_a_bound_too() -> None:
    with pytest.raises(InputError, match=r"steps: 1000000000 is not a whole number from 1 to 100000"):
        read_scenario("mine", (WHOLE + SEGMENT).replace("steps = 3", "steps = 1000000000"))


@pytest.mark.parametrize("suffix", ["", ".toml", ".csv"])
def test_a_name_that_no_file_can_have_is_that_of_no_scenario(suffix: str) -> None:
    with pytest.raises(InputError, match=r"^a{60,100}\.\.\.: no such") as refusal:
        load_scenario(300 * "a" + suffix)
    assert len(str(refusal.value)) < 400


@pytest.mark.parametrize(("suffix", "command"), [(".ssp", "simulate"), (".fmu", "check"), (".ssv", "run")])
def test_a_file_of_another_kind_is_told_what_takes_it(tmp_path: Path, suffix: str, command: str) -> None:
    path = tmp_path / f"extended{suffix}"
    path.write_bytes(b"PK")
    with pytest.raises(InputError, match=f"is no scenario; it is .*: warmlink {command} .*extended"):
        load_scenario(str(path))


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


def test_a_temperature_whose_0_has_a_meaning_is_none_the_less_a_temperature() -> None:
    told = "link.reference_temperature"
    for given, expected in (("20 degC", 293.15), ("68 degF", 293.15), ("0 K", 0.0), (0, 0.0)):
        assert start_values({told: given}, CELL, "mine")["link"]["reference_temperature"] == pytest.approx(
            expected
        )


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("arm.length", 1, "there is no component arm"),
        ("link.lenght", 1, "did you mean length"),
        ("length", 1, r"length: names no component; did you mean link\.length\?"),
        ("foo", 1, "foo: names no component; choose motor or link, with a dot and the variable after it"),
        ("link.length", "3 kg", "kg does not convert to m"),
        ("link.length", "3 furlnogs", "not a known unit"),
        ("link.length", "long", "is not a value"),
        ("link.length", "nan", "not a finite number"),
        ("link.width", "-20 mm", r"link.width: -0.02 m is not positive"),
        ("link.tip_position", "50 cm", "lies beyond the link's end"),
        ("link.length", "460", r"460 m is too high \(at most 20 m\); did you mean 460 mm\?"),
        ("link.width", 25.4, r"25.4 m is too high \(at most 1 m\); did you mean 25.4 mm\?"),
        ("link.cross_section", "161 m2", r"did you mean 161 mm2\?"),
        ("link.length", "5 km", "link.length: 5000 m is too high; give at most 20 m"),
        ("link.length", "30 km", "link.length: 30000 m is too high; give at most 20 m"),
    ],
)
def test_a_bad_start_value_is_refused_in_one_sentence(name: str, value: Any, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as refusal:
        start_values({name: value}, CELL, "mine")
    assert "\n" not in str(refusal.value)


def test_a_bare_number_is_in_the_si_unit() -> None:
    assert quantity(2.5, "N.m", "torque") == 2.5
    assert quantity("2.5", "N.m", "torque") == 2.5


def test_whole_numbers_and_truth_keep_their_type() -> None:
    """A system refuses the value of an integer as a real number."""
    given = {"sensors.fault_kind[3]": "3", "duty.repeat": 1}
    values = start_values(given, {"sensors": SENSORS, "duty": DUTY}, "mine")
    assert values == {"sensors": {"fault_kind[3]": 3}, "duty": {"repeat": True}}
    assert [type(values["sensors"]["fault_kind[3]"]), type(values["duty"]["repeat"])] == [int, bool]


def test_a_parameter_that_the_duty_cycle_sets_is_refused_where_it_would_have_no_effect() -> None:
    scenario = load_scenario("warm_up")
    said = scenario.values()["duty"]
    same = {"duty.segment_speed[1]": said["segment_speed[1]"]}
    assert replace(scenario, parameters=same).values()["duty"] == said
    with pytest.raises(InputError, match=r"duty.segment_speed\[1\] is set by the duty cycle wind"):
        _ = replace(scenario, parameters={"duty.segment_speed[1]": "0 rad/s"}).values()


@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [
        ("2.5 Nm", "N.m", 2.5),
        ("300 mNm", "N.m", 0.3),
        ("1.2 Nm/A", "N.m/A", 1.2),
        ("2 1/Nm", "1/(N.m)", 2),
        ("3 C/min", "K/s", 0.05),
        ("60 1/min", "rad/s", 2 * math.pi),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("60 U/min", "rad/s", 2 * math.pi),
        ("22 °C", "K", 295.15),
        ("22 C", "K", 295.15),
        ("71.6 F", "K", 295.15),
        ("1 1/min", "1/s", 1 / 60),
    ],
)
def test_units_are_read_as_people_write_them(written: str, unit: str, value: float) -> None:
    assert quantity(written, unit) == pytest.approx(value, rel=1e-12)
