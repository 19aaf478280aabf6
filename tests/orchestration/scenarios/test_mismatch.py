from dataclasses import replace
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.mismatch import EXPANSION, THERMAL_PARAMETERS, Mismatch
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.studies.plants import plant_in

IDLE = replace(load_scenario("windshield_wiper"), controller=catalogue.shipped("none"))


@pytest.mark.parametrize("name", [*mismatches.names(), "draw_1", "draw_12"])
def test_every_mismatch_gives_values_that_the_components_take(name: str) -> None:
    mismatch = mismatches.load(name)
    applied = IDLE.mismatched(mismatch)
    applied.values()
    assert mismatch.about
    assert bool(applied.parameters) == (name != "nominal")
    assert applied.mismatches == (name,)
    assert applied.believed == {}


def test_the_corners_are_20_percent_and_3_percent_off() -> None:
    for name, thermal, expansion in (("thermal_high", 1.2, 1.03), ("thermal_low", 0.8, 0.97)):
        scale = mismatches.load(name).scale
        assert set(scale) == {*THERMAL_PARAMETERS, EXPANSION}
        assert {scale[parameter] for parameter in THERMAL_PARAMETERS} == {thermal}
        assert scale[EXPANSION] == expansion


def test_draws_repeat_differ_and_keep_within_their_bounds() -> None:
    draws = [mismatches.draw(seed).scale for seed in range(200)]
    assert draws[3] == mismatches.load("draw_3").scale
    assert draws[3] != draws[4]
    for name in THERMAL_PARAMETERS:
        factors = [draw[name] for draw in draws]
        assert 0.8 <= min(factors) < 0.81
        assert 1.19 < max(factors) <= 1.2
    assert all(0.97 <= draw[EXPANSION] <= 1.03 for draw in draws)


def test_a_factor_acts_on_the_scenarios_value_where_it_gives_one() -> None:
    mismatch = Mismatch("mine", "", {"motor.joint_conductance": 2.0, "link.length": 1.5})
    given = replace(IDLE, parameters={"motor.joint_conductance": "3 W/K"})
    applied = given.mismatched(mismatch).parameters
    assert applied["motor.joint_conductance"] == 6.0
    assert applied["link.length"] == pytest.approx(1.5 * 0.3302)


def test_only_what_changes_the_elongation_touches_the_plant() -> None:
    touching = {name for name in mismatches.names() if mismatches.load(name).touches_plant}
    assert set(mismatches.names()) - touching == {"nominal", "noisy_sensors", "camera_absent"}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("about = ", "not readable as TOML"),
        ("factor = 3", "factor is not known"),
        ("scale = 3", "scale: 3 is not a table"),
        ("parameters = 3", "parameters: 3 is not a table"),
        ("[parameters]\nlink.length = '1 m'", "put the whole name in quotes"),
        ("about = 3", "about: 3 is no text"),
        ("[scale]\n'link.length' = " + 400 * "9", "a number beyond 64 bits is no factor"),
        ("[scale]\n'link.length' = inf", "inf is no factor"),
        ("[scale]\n'link.length' = 0", "0 is no factor"),
        ("[scale]\n'link.length' = nan", "nan is no factor"),
        ("[scale]\n'link.length' = true", "true is no factor"),
        ("[scale]\n'link.lenght' = 1.1", "did you mean length"),
        ("[scale]\n'arm.length' = 1.1", "there is no component arm"),
        ("[parameters]\n'link.length' = '3 kg'", "kg does not convert to m"),
    ],
)
def test_a_bad_mismatch_is_refused_in_one_sentence(content: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(content)
    with pytest.raises(InputError, match=sentence) as refusal:
        IDLE.mismatched(mismatches.load(str(path))).values()
    assert "\n" not in str(refusal.value)


def test_an_unknown_mismatch_names_those_there_are() -> None:
    with pytest.raises(InputError, match="thermal_high"):
        mismatches.load("nothing")


def test_a_scenario_names_its_mismatches_and_a_design_goes_by_the_cell_without_them() -> None:
    given = {"motor.joint_conductance": "2 W/K"}
    plain = changed(load_scenario("windshield_wiper"), controller="observer", parameters=given)
    wanted = changed(plain, mismatches=["noisy_sensors", "draw_1"])
    found = changed(load_scenario("warm_up"), parameters=given)
    assert found.mismatches == ("noisy_sensors", "draw_1")
    assert found.values() == wanted.values()
    assert found.values() != plain.values()
    assert found.as_believed.values() == plain.values()
    assert dict(plant_in(found).given) == dict(plant_in(plain).given)
    with pytest.raises(InputError, match="draw_one: no such mismatch"):
        read_scenario("mine", 'duty = "stop_and_go"\nmismatches = ["draw_one"]\n')
