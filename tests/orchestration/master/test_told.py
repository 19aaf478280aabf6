"""What slaves are told: start values in time, the truth about going back, tolerances; and how they end."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.orchestration.simulated import simulate as simulated
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.doubling import StepDoubling
from warmlink.orchestration.master.algorithms.explicit import GaussSeidel, Jacobi
from warmlink.orchestration.master.algorithms.iterated import FixedPoint, InterfaceNewton
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.isolation import Isolation
from warmlink.orchestration.simulation import experiment_of, remarks_on_steps
from warmlink.orchestration.system.model import DefaultExperiment, FmuPart, System, Value
from warmlink.orchestration.system.write import write_ssp

from .hand_written import compiled

SHOWN = ("y", "tolerance", "forward", "steps", "time")
FORMS = ("plain", "compiled", "isolated")
WAYS = [*product(("2.0", "3.0"), FORMS[:2]), ("3.0", "isolated")]
"""Version of the slave and form of the run; another process is told the same of either version."""


def description(version: str, **flags: str) -> str:
    """Model description of the slave in `told.c`."""
    names = ("k", *SHOWN, "only_step", "discard_at", "end_at", "stubborn")
    starts = dict(zip(("k", *names[6:]), ("1", "0", "1e300", "1e300", "0"), strict=True))
    number = ("ScalarVariable", "Float64")[version == "3.0"]
    variables, outputs = [], []
    for i, name in enumerate(names):
        shown = name in SHOWN
        start = "" if shown else f' start="{starts[name]}"'
        head = (
            f'<{number} name="{name}" valueReference="{i}" causality="{"output" if shown else "parameter"}"'
        )
        head += "" if shown else ' variability="fixed"'
        variables.append(
            f"{head}{start}/>" if version == "3.0" else f"{head}><Real{start}/></ScalarVariable>"
        )
        if shown:
            outputs.append(
                f'<Output valueReference="{i}" dependencies=""/>'
                if version == "3.0"
                else f'<Unknown index="{i + 1}" dependencies=""/>'
            )
    asked = {"canHandleVariableCommunicationStepSize": "true", **flags}
    state = "canGetAndSetFMUState" if version == "3.0" else "canGetAndSetFMUstate"
    slave = "".join(
        f' {key}="{value}"' for key, value in {state: "true", **asked}.items() if key != "stepSize"
    )
    step = f' stepSize="{flags["stepSize"]}"' if "stepSize" in flags else ""
    listed = "".join(outputs) if version == "3.0" else f"<Outputs>{''.join(outputs)}</Outputs>"
    token = "instantiationToken" if version == "3.0" else "guid"
    return (
        f'<fmiModelDescription fmiVersion="{version}" modelName="Told" {token}="told">'
        f'<CoSimulation modelIdentifier="Told"{slave}/><DefaultExperiment tolerance="1e-6"{step}/>'
        f"<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{listed}</ModelStructure></fmiModelDescription>"
    )


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def told(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = Path(__file__).with_name("told.c")
    return compiled(tmp_path_factory.mktemp("told"), source, description(request.param))


@pytest.fixture(scope="module")
def told2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = Path(__file__).with_name("told.c")
    return compiled(tmp_path_factory.mktemp("told2"), source, description("2.0"))


def system(fmu: Path, **values: dict[str, Value]) -> System:
    return System("s", {name: FmuPart(name, fmu, {}, given) for name, given in values.items()})


def ran(made: System, form: str = "plain", by: Algorithm | None = None, **how: Any) -> Result:
    """Ten steps of 1 s, stepped in one of the forms."""
    if form == "isolated":
        return simulate(made, 10.0, 1.0, by, isolation=Isolation(), **how)
    return simulate(made, 10.0, 1.0, by, stepping="compiled" if form == "compiled" else "plain", **how)


@pytest.mark.parametrize(("told", "form"), WAYS, indirect=["told"])
def test_start_values_outlast_the_setup_of_the_experiment(told: Path, form: str) -> None:
    result = ran(system(told, a={"k": 5.0}), form)
    np.testing.assert_array_equal(result["a.y"], 5.0)


@pytest.mark.parametrize(("told", "form"), WAYS, indirect=["told"])
def test_a_slave_is_told_its_own_tolerance_or_the_one_that_is_asked_for(told: Path, form: str) -> None:
    made = system(told, a={})
    assert ran(made, form)["a.tolerance"][-1] == 1e-6
    assert ran(made, form, fmu_tolerance=1e-3)["a.tolerance"][-1] == 1e-3


@pytest.mark.parametrize(("told", "form"), WAYS, indirect=["told"])
@pytest.mark.parametrize("by", [Jacobi(), GaussSeidel(), GaussSeidel(sequence=("a",))])
def test_time_goes_forward_only_where_nobody_goes_back(told: Path, form: str, by: Algorithm) -> None:
    result = ran(system(told, a={"stubborn": 1.0}), form, by)
    np.testing.assert_array_equal(result["a.forward"][1:], 1.0)
    np.testing.assert_allclose(result["a.time"], result.times)


def test_each_algorithm_says_whether_it_goes_back(told: Path) -> None:
    """Who repeats a step begins at the present point again, which is not before it."""
    made = system(told, a={})
    doubling = StepDoubling(GaussSeidel(), {"a.time": 1e9})
    algorithms: tuple[Algorithm, ...] = FixedPoint(), InterfaceNewton(), doubling
    for by, forward in zip(algorithms, (1.0, 1.0, 0.0), strict=True):
        assert by.goes_back == (forward == 0.0)
        np.testing.assert_array_equal(ran(made, by=by)["a.forward"][1:], forward)


@pytest.mark.parametrize(("told", "form"), WAYS, indirect=["told"])
def test_a_discarded_step_begins_the_run_anew_with_the_other_truth(told: Path, form: str) -> None:
    made = system(told, a={"discard_at": 4.0})
    np.testing.assert_array_equal(ran(made, form)["a.forward"][1:], 0.0)
    result = ran(made, form, record=["a.time"])
    assert result.status == "completed"
    np.testing.assert_allclose(result["a.time"], result.times)
    assert result.remarks == ()


def test_it_is_said_where_a_slave_behaves_in_another_way_then(told: Path) -> None:
    result = ran(system(told, a={"discard_at": 4.0, "stubborn": 1.0}))
    (remark,) = result.remarks
    assert remark.startswith("a.forward is 1 at 4 s in a run that never repeats a step, and 0 in this one")


def test_a_run_that_keeps_pace_is_not_begun_anew(told: Path) -> None:
    result = ran(system(told, a={"discard_at": 4.0}), pacing=1e6)
    assert str(result.reason).endswith("no smaller step was tried, for the run keeps pace")
    assert len(result.times) == 5


@pytest.mark.parametrize(("told", "form"), WAYS, indirect=["told"])
@pytest.mark.parametrize("order", ["first", "last"])
def test_a_slave_that_asks_to_end_ends_the_run_with_the_row_of_its_end(
    told: Path, form: str, order: str
) -> None:
    parts: dict[str, dict[str, Value]] = {"a": {"end_at": 3.0}, "b": {}}
    made = system(told, **dict(sorted(parts.items(), reverse=order == "last")))
    result = ran(made, form)
    assert (result.status, result.stopped) == ("ended", None)
    np.testing.assert_array_equal(result.times, [0.0, 1.0, 2.0, 3.0])
    for name in ("a", "b"):
        np.testing.assert_allclose(result[f"{name}.time"], result.times)
    assert result.remarks == (result.reason,)
    assert str(result.reason).startswith("a: ended at 3 s: fmi")


def test_the_command_takes_such_an_end_for_one(
    told: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    made = replace(system(told, a={"end_at": 3.0}), default_experiment=DefaultExperiment(0.0, 10.0, 1.0))
    write_ssp(made, Path("s.ssp"))
    answer, err = simulated(Path("s.ssp"), "--out", "o", capsys=capsys)
    assert (answer["stop_time_s"], answer["stopped"]) == (3.0, None)
    assert answer["outputs"]["a.time"]["coupling_error"] == 0.0
    assert "asks to end the simulation" in err
    assert len(pd.read_csv("o/results.csv")) == 4


@pytest.mark.parametrize("form", FORMS)
def test_one_that_ends_within_a_step_keeps_the_rows_before(told2: Path, form: str) -> None:
    """Its last successful time is then another than the end of the step."""
    result = ran(system(told2, a={"end_at": 2.5}, b={}), form)
    assert result.status == "ended"
    np.testing.assert_array_equal(result.times, [0.0, 1.0, 2.0])
    assert str(result.reason).startswith("a: ended at 2 s: fmi2DoStep answered discard and asks to end")


def test_of_an_fmu_that_may_be_instantiated_once_each_further_instance_has_a_process(
    tmp_path: Path,
) -> None:
    flags = {"canBeInstantiatedOnlyOncePerProcess": "true"}
    once = compiled(tmp_path, Path(__file__).with_name("told.c"), description("2.0", **flags))
    result = ran(system(once, a={"k": 1.0}, b={"k": 5.0}, c={}))
    assert (result["a.y"][-1], result["b.y"][-1]) == (1.0, 5.0)
    for name in ("a", "b", "c"):  # each counts its own steps alone
        assert result[f"{name}.steps"][-1] == 10.0
    told = "a process may hold one instance of its FMU, so that it has a process of its own"
    assert result.remarks == (f"b: {told}", f"c: {told}")


def test_instances_in_one_process_count_together(told2: Path) -> None:
    """Which the test before would not see if each library were loaded anew."""
    result = ran(system(told2, a={}, b={}))
    assert result["b.steps"][-1] == 20.0


def stepped(folder: Path, version: str, step: float, **flags: str) -> Path:
    """The slave that takes steps of one size alone."""
    flags = {"canHandleVariableCommunicationStepSize": "false", **flags}
    made = description(version, **flags).replace('start="0"', f'start="{step}"', 1)
    return compiled(folder, Path(__file__).with_name("told.c"), made)


def test_the_step_of_an_fmu_that_takes_no_other_is_taken(tmp_path: Path) -> None:
    fmu = stepped(tmp_path, "2.0", 0.3, stepSize="0.3")
    made = replace(system(fmu, a={"only_step": 0.3}), default_experiment=DefaultExperiment(0.0, 1.0))
    stop, step = experiment_of(made, None, None)
    assert (stop, step) == pytest.approx((0.9, 0.3))
    assert simulate(made, stop, step).status == "completed"
    assert remarks_on_steps(made, stop, step) == [
        "the run ends at 0.9 s: no step of 0.3 s ends at 1 s, and a declares that it takes no others"
    ]


@pytest.mark.usefixtures("as_a_command")
def test_the_advice_on_another_step_is_one_that_runs(tmp_path: Path) -> None:
    fmu = stepped(tmp_path, "2.0", 0.3, stepSize="0.3")
    made = replace(system(fmu, a={"only_step": 0.3}), default_experiment=DefaultExperiment(0.0, 1.0))
    stop, step = experiment_of(made, None, "0.1 s")
    (remark,) = remarks_on_steps(made, stop, step)
    assert remark == (
        'a: proposes steps of 0.3 s and declares that it takes no others; give --step "0.3 s" --stop "0.9 s"'
    )
    assert simulate(made, *experiment_of(made, "0.9 s", "0.3 s")).status == "completed"


def test_fmus_of_two_steps_meet_at_the_least_common_one(tmp_path: Path) -> None:
    made = System("s", {})
    for name, step in (("a", "0.3"), ("b", "0.2")):
        (tmp_path / name).mkdir()
        made.components[name] = FmuPart(name, stepped(tmp_path / name, "2.0", 0.0, stepSize=step))
    assert experiment_of(made, "6 s", None) == pytest.approx((6.0, 0.6))


def test_an_internal_step_that_the_run_misses_is_said(tmp_path: Path) -> None:
    fmu = compiled(
        tmp_path, Path(__file__).with_name("told.c"), description("3.0", fixedInternalStepSize="0.02")
    )
    made = system(fmu, a={})
    assert experiment_of(made, "1 s", None) == (1.0, 0.02)
    stop, step = experiment_of(made, "33.4 s", None)
    assert (stop, step) == pytest.approx((33.4, 0.1))  # 0.0668 s, made a multiple that divides the run
    assert remarks_on_steps(made, stop, step) == []
    assert remarks_on_steps(made, 1.0, 0.1) == []
    (remark,) = remarks_on_steps(made, 1.0, 0.05)
    assert remark.startswith("a: goes on by 0.02 s inside, which does not divide the run's steps of 0.05 s")
