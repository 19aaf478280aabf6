"""What is said of a law that was designed for another cell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.orchestration.machine.strangers import machine
from warmlink.controllers.design.plant import cell_plant
from warmlink.controllers.design.shipped import PLANT_FACTS
from warmlink.controllers.start_values import by_scalar
from warmlink.fmus.arguments import speaking_of_options
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.command_line.arguments import OPTIONS
from warmlink.orchestration.scenarios.scenario import Scenario, changed
from warmlink.orchestration.shell import quoted

NOMINAL = "windshield_wiper"


def test_a_design_for_another_cell_is_not_told_to_be_added_again() -> None:
    """The remark ended in "then add --parameters observer.ssv", which was given."""
    other = PLANT_FACTS["observer"](cell_plant({}, {"conductivity": 100.0}))
    given = {f"compensator.{name}": value for name, value in by_scalar(other).items()}
    scenario = replace(load_scenario(NOMINAL), controller=shipped("observer"), parameters=given)
    told, _ = design_check(scenario)
    assert told is not None
    assert told.startswith(
        "observer was designed for another cell; this one is the nominal one; leave out the"
    )
    assert "then add" not in told
    same = replace(scenario, parameters={**given, "link.conductivity": 100.0})
    assert design_check(same)[0] is None


def test_what_to_add_is_an_argument_in_python_and_an_option_of_the_command() -> None:
    other = {"link.conductivity": "100 W/(m*K)"}
    laws = {law: replace(load_scenario(NOMINAL), controller=shipped(law)) for law in ("observer", "analytic")}
    differing = {law: replace(each, parameters=other) for law, each in laws.items()}
    told = {law: str(design_check(each)[0]) for law, each in differing.items()}
    assert told["observer"].endswith("; then add parameters='observer.ssv'")
    assert told["analytic"].endswith("; then run with controller='observer' parameters='observer.ssv'")
    with speaking_of_options(OPTIONS, quoted):
        told = {law: str(design_check(each)[0]) for law, each in differing.items()}
    assert told["observer"].endswith("; then add --parameters observer.ssv")
    assert told["analytic"].endswith("; then run with --controller observer --parameters observer.ssv")


def test_a_law_without_a_design_is_not_judged_once_somebody_gave_it_values() -> None:
    lag = replace(load_scenario(NOMINAL), controller=shipped("lag"))
    other = replace(lag, parameters={"link.conductivity": "100 W/(m*K)"})
    assert "suit" in str(design_check(other)[0])
    own = replace(other, parameters={**other.parameters, "compensator.gain": "5 um/W"})
    assert design_check(own) == (None, False)


@pytest.fixture(scope="module")
def longer() -> tuple[Scenario, tuple[str | None, bool]]:
    """A link of another length, and what is said of it."""
    scenario = changed(load_scenario(NOMINAL), "lag", {"link.length": "400 mm"})
    return scenario, design_check(scenario)


@pytest.mark.parametrize(
    "value",
    [
        {"sample_time": "2 s"},
        {"tolerance": "3 um"},
        {"correction_limit": "300 um"},
        {"correction_rate_limit": "10 um/s"},
        {"warning_limit": "100 um"},
    ],
)
def test_limits_that_somebody_gave_are_no_design(
    value: dict[str, str], longer: tuple[Scenario, tuple[str | None, bool]]
) -> None:
    scenario, said = longer
    given = changed(scenario, None, {f"compensator.{name}": text for name, text in value.items()})
    assert design_check(given) == said
    assert "suit" in str(said[0])


@pytest.mark.parametrize(("noise", "ideal"), [("0 K", True), ("0.1 K", False)])
def test_thermometers_without_noise_are_ideal_however_that_is_said(noise: str, ideal: bool) -> None:
    asked = f'duty = "{NOMINAL}"\ncontroller = "observer"\n'
    assert design_check(read_scenario("mine", asked)) == (None, True)
    assert design_check(read_scenario("mine", f'{asked}[sensors]\nnoise = "{noise}"\n')) == (None, ideal)


def test_a_command_repeats_nothing_that_the_file_says(tmp_path: Path) -> None:
    """Beside a mismatch it did: the file's values were compared with the mismatch on top."""
    path = tmp_path / "steel.toml"
    cell = f'duty = "{NOMINAL}"\ncontroller = "observer"\n[materials]\nlink = "steel"\n'
    path.write_text(cell)
    told, _ = design_check(load_scenario(str(path)))
    assert "--set" not in str(told)
    path.write_text(f'mismatches = ["draw_1"]\n{cell}')
    assert design_check(load_scenario(str(path)))[0] == told
    anew = design_check(changed(load_scenario(str(path)), None, {"link.length": "400 mm"}))[0]
    assert str(anew).count("--set") == 1


def test_a_start_value_that_has_no_effect_is_refused_before_any_advice() -> None:
    fed = replace(load_scenario(NOMINAL), parameters={"link.heat_flow": "3 W"})
    with pytest.raises(InputError, match=r"link\.heat_flow is fed by"):
        design_check(fed)


def test_nothing_is_said_where_there_is_nothing_to_advise(tmp_path: Path) -> None:
    """No law, a machine with designs of its own, a plant that no design knows, a change that none sees."""
    nominal = load_scenario(NOMINAL)
    lag = replace(nominal, controller=shipped("lag"))
    for quiet in (
        replace(nominal, controller=shipped("none")),
        load_scenario("six_axis_shift"),
        load_scenario(str(machine("spindle", tmp_path))),
        replace(lag, parameters={"motor.initial_shaft_temperature": "23 degC"}),
    ):
        assert design_check(quiet) == (None, False), quiet.name


def test_a_machine_of_others_is_told_which_law_any_machine_can_have(tmp_path: Path) -> None:
    spindle = load_scenario(str(machine("spindle", tmp_path)))
    told, ideal = design_check(replace(spindle, controller=shipped("observer")))
    assert str(told).startswith(
        "observer was designed for another cell; this one is Spindle; find a law from"
    )
    assert "controller='linear_observer'" in str(told)
    assert not ideal
    given = replace(
        spindle, controller=shipped("linear_observer"), parameters={"compensator.dynamics[1]": -1.0}
    )
    assert design_check(given) == (None, False)
