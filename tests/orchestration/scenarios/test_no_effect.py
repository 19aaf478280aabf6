"""What a user sets has its effect, once, or is refused."""

from pathlib import Path

import pytest

import warmlink.orchestration.api as wl
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.closed_loop.outcome import run
from warmlink.orchestration.scenarios.mismatch import together
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.studies.study import read_study

DUTY = 'duty = "stop_and_go"\n'


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("motor.speed", "motor.speed is fed by duty.speed, .* change the duty cycle"),
        ("link.heat_flow", "link.heat_flow is fed by motor.heat_flow, .* set parameters of motor"),
        ("compensator.tip_temperature", "fed by sensors.reading.*set parameters of sensors"),
    ],
)
def test_a_start_value_of_an_input_that_a_wire_feeds_is_refused(
    name: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=sentence):
        changed(load_scenario("stop_and_go"), parameters={name: 0.0}).values()
    with pytest.raises(InputError, match=sentence):
        read_scenario("mine", f'{DUTY}[parameters]\n"{name}" = 0\n').values()
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(f'[parameters]\n"{name}" = 0\n')
    with pytest.raises(InputError, match=sentence):
        changed(load_scenario("stop_and_go"), mismatches=[str(wrong)]).values()
    study = {"controller": "lag", "duty_cycles": ["stop_and_go"], "parameters": {name: {"values": [0, 1]}}}
    with pytest.raises(InputError, match=sentence):
        read_study("mine", study, tmp_path)


def test_inputs_that_no_wire_feeds_may_be_set() -> None:
    found = changed(load_scenario("stop_and_go"), parameters={"link.tip_heat_flow": "1 W"})
    assert found.values()["link"] == {"tip_heat_flow": 1.0}


@pytest.mark.parametrize("entry", ["tolerance", "coupling_tolerance"])
@pytest.mark.parametrize("value", ["10", '"10"', "0.5"])
def test_a_length_without_a_unit_is_refused_with_both_that_may_be_meant(entry: str, value: str) -> None:
    text = value.strip('"')
    with pytest.raises(InputError, match=f'{entry}: {text} has no unit; write "{text} um" or "{text} m"'):
        read_scenario("mine", f"{DUTY}{entry} = {value}\n")


def test_a_tolerance_as_a_text_needs_its_unit_and_a_number_of_python_is_in_si() -> None:
    with pytest.raises(InputError, match='10 has no unit; write "10 um"'):
        run("stop_and_go", tolerance="10")
    assert wl.run("stop_and_go", stop="10 s", tolerance=1e-6).scenario.coupling_tolerance == 1e-6


def test_a_temperature_without_a_unit_is_in_kelvin_unless_it_is_too_cold() -> None:
    segment = "stop_time = '1 h'\n[[segment]]\nduration = '1 h'\nambient_temperature = {}\n"
    scenario = read_scenario("mine", segment.format(295.15))
    assert (
        scenario.duty.start_values() == read_scenario("mine", segment.format("'22 degC'")).duty.start_values()
    )
    with pytest.raises(InputError, match='22 has no unit; write "22 degC" or "22 K"'):
        read_scenario("mine", segment.format(22))


def test_a_mismatch_that_is_there_already_counts_once_and_this_is_said(tmp_path: Path) -> None:
    once = changed(load_scenario("windshield_wiper"), mismatches=["thermal_high"])
    assert once.remarks == ()
    twice = changed(load_scenario("windshield_wiper"), mismatches=["thermal_high"] * 3)
    again = changed(once, mismatches=["thermal_high"])
    for each in (twice, again):
        assert each.values() == once.values()
        assert each.mismatches == ("thermal_high",)
        assert each.remarks == ("the mismatch thermal_high is there already; it counts once",)
    shown = run(again, stop="10 s").summary()
    assert "thermal_high is there already" in shown


def test_a_scenario_finds_its_mismatch_beside_itself_and_keeps_it(tmp_path: Path) -> None:
    (tmp_path / "longer.toml").write_text('[scale]\n"link.expansion_coefficient" = 1.25\n')
    (tmp_path / "mine.toml").write_text(f'{DUTY}mismatches = ["longer.toml"]\n')
    scenario = load_scenario(str(tmp_path / "mine.toml"))
    link = changed(scenario, controller="none").values()["link"]
    assert link["expansion_coefficient"] == pytest.approx(1.25 * 23.6e-6)


def test_mismatches_that_cancel_say_so_and_the_cell_is_still_called_perfect(tmp_path: Path) -> None:
    for name, factor in (("longer", 1.2), ("shorter", 0.83334)):
        (tmp_path / f"{name}.toml").write_text(f'[scale]\n"link.expansion_coefficient" = {factor}\n')
    paths = [str(tmp_path / f"{name}.toml") for name in ("longer", "shorter")]
    outcome = run("stop_and_go", "observer", mismatches=paths, stop="20 min")
    told = "link.expansion_coefficient: longer and shorter together make it 1 times as large"
    assert together(outcome.scenario.differences) == [told]
    assert told in outcome.remarks
    assert any("the thermometers are perfect" in each for each in outcome.remarks)
