from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from warmlink.fmus.errors import InputError
from warmlink.orchestration.studies.axis import Axis
from warmlink.orchestration.studies.study import load_study, names, read_study

GIVEN: dict[str, Any] = {
    "controller": "lag",
    "duty_cycles": ["windshield_wiper"],
    "parameters": {"compensator.gain": {"min": "2 um/W", "max": "8 um/W"}},
}


@pytest.mark.parametrize("name", names())
def test_every_shipped_study_reads(name: str) -> None:
    study = load_study(name)
    assert study.title
    assert study.axes
    assert study.shipped is not None


def test_bounds_are_converted_and_the_shipped_point_is_known() -> None:
    study = read_study("mine", GIVEN, Path())
    assert (study.axes[0].low, study.axes[0].high) == (pytest.approx(2e-6), pytest.approx(8e-6))
    assert study.shipped == {"compensator.gain": 4.21e-6}
    narrow = {**GIVEN, "parameters": {"compensator.gain": {"min": 5e-6, "max": 6e-6}}}
    assert read_study("mine", narrow, Path()).shipped is None


def test_a_point_meets_every_duty_cycle_and_mismatch() -> None:
    given = {**GIVEN, "duty_cycles": ["windshield_wiper", "stop_and_go"], "mismatches": ["nominal", "draw_1"]}
    given["parameters"] = {"motor.joint_conductance": {"min": 0.5, "max": 2.0}}
    study = read_study("mine", given, Path())
    cases = study.cases({"motor.joint_conductance": 1.5}, "point 0")
    assert [case.label[1:] for case in cases] == study.run_names
    factor = dict(study.mismatches[1].scale)["motor.joint_conductance"]
    assert [case.values["motor"]["joint_conductance"] for case in cases] == pytest.approx(
        [1.5, 1.5 * factor] * 2
    )


def test_the_digest_knows_what_matters_and_nothing_else() -> None:
    first = read_study("mine", GIVEN, Path()).digest("fmus")
    assert read_study("other", {**GIVEN, "title": "x", "tune": {"trials": 9}}, Path()).digest("fmus") == first
    for change in ({"seed": 2}, {"tune": {"batch": 3}}, {"duty_cycles": ["stop_and_go"]}, {"step_size": 2}):
        assert read_study("mine", {**GIVEN, **change}, Path()).digest("fmus") != first
    assert read_study("mine", GIVEN, Path()).digest("others") != first


def changed(**change: Any) -> dict[str, Any]:
    return {**GIVEN, **change}


def varied(name: str, **table: Any) -> dict[str, Any]:
    return changed(parameters={name: table})


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (changed(colour=1), "colour is not known"),
        (changed(controller="magic"), "magic: no such controller"),
        ({**GIVEN, "controller": 3}, "controller: 3 is no text"),
        (
            {key: GIVEN[key] for key in GIVEN if key != "controller"},
            'controller is missing; write controller = "lag"',
        ),
        (changed(duty_cycles=["nothing"]), "nothing: no such"),
        (changed(duty_cycles=[]), "duty_cycles: is no list of names"),
        (changed(duty_cycles=["stop_and_go", "stop_and_go"]), "names one twice"),
        (changed(mismatches=["nothing"]), "nothing: no such mismatch"),
        (changed(parameters={}), "varies nothing"),
        (varied("compensator.gian", min=1, max=2), "did you mean gain"),
        (varied("arm.gain", min=1, max=2), "there is no component arm"),
        (varied("compensator.gain", min="2 um/W", max="2 um/W"), "nothing lies between"),
        (varied("compensator.gain", min="3 um/W", max="2 um/W"), "nothing lies between"),
        (varied("compensator.gain", min="2 um/W"), "has no bounds"),
        (varied("compensator.gain", min="2 kg", max="3 kg"), "kg does not convert"),
        (varied("compensator.gain", min="nan", max="3 um/W"), "not a finite number"),
        (varied("compensator.gain", values=[]), "nothing to choose from"),
        (varied("compensator.gain", values=[1], max=3), "has bounds and values"),
        (varied("compensator.gain", min=0, max=1, log=True), "bounds above 0"),
        (varied("compensator.time_constant", min="-1 s", max="9 s"), "time_constant: -1 s is not positive"),
        (changed(constraint={}), "constraint: a table is not a list of tables"),
        (changed(constraint=[{"metric": "rms_um"}]), "constraint 1: at_most is missing"),
        (changed(seed=-1), "seed: -1 is not a whole number from 0 to 4294967295"),
        (changed(tune={"trials": 0}), "tune.trials: 0 is not a whole number from 1 to 100000"),
        (changed(tune={"sampler": "magic"}), "'magic' is not known; choose tpe or random"),
        (changed(tune={"storage": "study.db"}), "is no URL"),
        (changed(sweep={"kind": "magic"}), "choose grid or latin_hypercube"),
        (changed(step_size="7 s"), "7 s"),
        (changed(master="magic"), "magic"),
    ],
)
def test_a_bad_study_is_refused_in_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as refusal:
        read_study("mine", given, Path())
    assert "\n" not in str(refusal.value)


@given(
    low=st.floats(1e-6, 10),
    span=st.floats(1e-3, 100),
    log=st.booleans(),
    integer=st.booleans(),
    share=st.floats(0, 1),
    count=st.integers(1, 9),
)
def test_values_of_an_axis_keep_within_its_bounds(
    low: float, span: float, log: bool, integer: bool, share: float, count: int
) -> None:
    if integer:
        low, span = float(max(round(low), log)), float(round(span) + 1)
    axis = Axis("motor.x", "1", low, low + span, log, integer, (), (low, low))
    values = [axis.at(share), *axis.levels(count)]
    assert all(axis.low <= value <= axis.high for value in values)
    assert not integer or all(value == round(value) for value in values)
    assert axis.levels(count) == sorted(axis.levels(count))
    assert len(set(axis.levels(count))) == len(axis.levels(count)) <= count


def test_whole_numbers_are_spread_by_their_logarithm_too() -> None:
    axis = Axis("motor.x", "1", 1.0, 1000.0, True, True, (), (1.0, 1.0))
    assert axis.levels(4) == [1.0, 10.0, 100.0, 1000.0]
    assert [axis.at(share) for share in (0.0, 1 / 3, 2 / 3, 1.0)] == [1.0, 10.0, 100.0, 1000.0]
    few = [replace(axis, high=3.0, log=False).at((i + 0.5) / 300) for i in range(300)]
    assert [few.count(value) for value in (1.0, 2.0, 3.0)] == [100, 100, 100]


def test_a_number_without_a_unit_is_shown_without_one() -> None:
    assert Axis("motor.x", "1", 1.0, 4.0, False, True, (), (1.0, 1.0)).shown(1.0, 4.0) == "1 to 4"


def test_the_point_where_nothing_is_changed_is_that_of_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text('duty = "stop_and_go"\n[parameters]\n"compensator.gain" = "3 um/W"\n')
    study = read_study("mine", {**GIVEN, "scenario": "cell.toml"}, tmp_path)
    assert study.shipped == {"compensator.gain": pytest.approx(3e-6)}


def test_a_shipped_value_is_known_however_it_was_written() -> None:
    """4.21 um/W are not quite 4.21e-6 m/W once converted."""
    for table in ({"values": ["4.21 um/W", "9 um/W"]}, {"min": "2 um/W", "max": "4.21 um/W"}):
        study = read_study("mine", varied("compensator.gain", **table), Path())
        assert study.shipped == {"compensator.gain": pytest.approx(4.21e-6, rel=1e-12)}
        chosen = study.shipped["compensator.gain"]
        assert chosen in (study.axes[0].choice or (study.axes[0].high,))


def test_no_point_is_the_shipped_one_where_scenarios_ship_several_values(tmp_path: Path) -> None:
    """The first scenario's gain was called the shipped one of all, and the first axis' that of six."""
    for name, gain in (("one", 3), ("two", 6)):
        text = f'duty = "stop_and_go"\n[parameters]\n"compensator.gain" = "{gain} um/W"\n'
        (tmp_path / f"{name}.toml").write_text(text)
    study = read_study("mine", changed(duty_cycles=["one.toml", "two.toml"]), tmp_path)
    assert study.shipped is None
    assert study.axes[0].shown(*study.axes[0].shipped) == "3 to 6 µm/W"
    alone = read_study("mine", changed(duty_cycles=["two.toml"]), tmp_path)
    assert alone.shipped == {"compensator.gain": pytest.approx(6e-6)}


def test_the_shipped_point_of_an_arm_is_that_of_all_its_axes() -> None:
    arm = changed(duty_cycles=["six_axis_shift"])
    assert read_study("mine", arm, Path()).shipped is None
    one = {"axis6.compensator.gain": GIVEN["parameters"]["compensator.gain"]}
    assert_shipped_changes_nothing({**arm, "parameters": one}, Path())


def test_the_shipped_point_is_without_the_mismatch_which_comes_on_top(tmp_path: Path) -> None:
    (tmp_path / "off.toml").write_text('duty = "stop_and_go"\nmismatches = ["draw_1"]\n')
    bounds = {"motor.joint_conductance": {"min": 0.5, "max": 2.0}}
    assert_shipped_changes_nothing(changed(duty_cycles=["off.toml"], parameters=bounds), tmp_path)


def assert_shipped_changes_nothing(given: dict[str, Any], folder: Path) -> None:
    study = read_study("mine", given, folder)
    assert study.shipped is not None
    for mine, without in zip(study.cases(study.shipped, ""), study.cases({}, ""), strict=True):
        for full in study.shipped:
            instance, _, name = full.rpartition(".")
            known = without.values[instance].get(name, study.shipped[full])
            assert mine.values[instance][name] == pytest.approx(known, rel=1e-12)
