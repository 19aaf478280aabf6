"""Which runs go on joined systems, and what is said of those that do not."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from warmlink.fmus.packaging.native import compile
from warmlink.fmus.packaging.native.rollout_code import compiled
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.progress import Progress
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies import session
from warmlink.orchestration.studies.case import BOUNDED, case_of
from warmlink.orchestration.studies.joined import agreeing, joined_systems
from warmlink.orchestration.studies.workers import (
    FmuSet,
    attempt,
    attempt_all,
    joined_outcomes,
    lane_of,
)
from warmlink.orchestration.system.units import Conversion
from warmlink.orchestration.written.expression import Expression

LAW = "LagCompensator"
NOMINAL = mismatch.load("nominal")


@pytest.fixture
def pause(folder: Path) -> Scenario:
    return replace(load_scenario(str(folder / "pause.toml")), controller=catalogue.shipped("lag"))


def joined(fmus: FmuSet, *scenarios: Scenario) -> FmuSet:
    said: list[str] = []
    whole = replace(fmus, rollouts=joined_systems(scenarios, said.append))
    assert said == []
    assert list(whole.rollouts) == [LAW]
    return whole


def remarks(fmus: FmuSet, scenarios: Sequence[Scenario]) -> list[str]:
    said: list[str] = []
    assert agreeing([each.mismatched(NOMINAL) for each in scenarios], fmus, said.append).rollouts == {}
    return said


def test_it_says_which_system_is_compiled_and_which_is_tried(
    pause: Scenario, fmus: FmuSet, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    doing: list[tuple[str, float | None]] = []

    @contextmanager
    def shown(what: str) -> Iterator[Progress]:
        yield lambda text, share=None: doing.append((f"{what}: {text}", share))

    monkeypatch.setattr(session, "spinner", shown)
    with session.open_study([pause.mismatched(NOMINAL)], session.USUAL, folder / "part"):
        shares = [share for _, share in doing if share is not None]
    assert [text for text, _ in doing] == [
        f"Preparing the runs: compiling system 1 of 1, with {LAW}",
        "Preparing the runs: looking for the runs to try beside the FMUs",
        f"Preparing the runs: trying {LAW} beside its FMUs",
    ]
    assert shares == sorted(shares)


@pytest.mark.parametrize("part", ["sensors.fault_kind[1]", "sensors.fault_kind[5]", "camera.fault_kind"])
def test_readings_that_drop_out_are_joined(pause: Scenario, fmus: FmuSet, part: str) -> None:
    dropout = replace(pause, parameters={part: 4, part.replace("kind", "time"): "100 s"})
    whole, case = joined(fmus, dropout), case_of(dropout, ("lag",), with_budget=True)
    (found,) = joined_outcomes([case], whole.rollouts).values()
    exact = attempt(case, fmus)
    assert exact.coupling_um is not None
    assert all(abs(getattr(found, name) - getattr(exact, name)) <= exact.coupling_um for name in BOUNDED)


def test_what_any_scenario_scores_is_recorded(pause: Scenario, fmus: FmuSet) -> None:
    cooled = Expression("link.elongation - compensator.correction - 1e-7 * (motor.shaft_temperature - 295)")
    other = replace(pause, machine=replace(pause.machine, roles=replace(pause.machine.roles, score=cooled)))
    whole = joined(fmus, pause, other)
    first, second = attempt_all([case_of(each, ("lag",)) for each in (pause, other)], whole)
    assert (first.stopped, second.stopped) == (None, None)
    assert first.max_abs_um != second.max_abs_um


def test_a_connection_that_scales_is_not_that_of_the_joined_system(pause: Scenario, fmus: FmuSet) -> None:
    joined(fmus, pause)
    held = replace(pause.machine, scaled={"link.heat_flow": Conversion(1.001, 0.0)})
    said: list[str] = []
    scaled = replace(pause, machine=held)
    assert joined_systems([scaled], said.append) == {}
    assert "a connection scales what it carries (link.heat_flow)" in said[0]


@pytest.mark.parametrize("finest", ["micro steps", "samples"])
def test_runs_of_more_steps_than_are_laid_out_stay_with_the_fmus(
    pause: Scenario, fmus: FmuSet, finest: str
) -> None:
    whole, case = joined(fmus, pause), case_of(pause, ("lag",))
    assert lane_of(case, whole.rollouts) is not None
    month = replace(case, stop_time=30 * 86400.0, step_size=3600.0)
    often = {**case.values, "sensors": {**case.values.get("sensors", {}), "sample_time": 1e-3}}
    fine = month if finest == "micro steps" else replace(case, values=often)
    assert lane_of(fine, whole.rollouts) is None


def test_it_is_said_that_the_run_which_was_tried_stopped(
    pause: Scenario, fmus: FmuSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stopped it may be mended: another study tries again."""
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path))
    hot = replace(pause, parameters={"motor.standby_power": 1e307})
    (said,) = remarks(joined(fmus, hot), [hot])
    assert said.startswith(f"{LAW}: runs on its FMUs, since the run that was tried of it stopped: ")
    assert "is not finite" in said
    assert not list((tmp_path / "agreements").glob("*"))


def test_it_is_said_that_no_joined_system_takes_the_run_which_was_tried(
    pause: Scenario, fmus: FmuSet
) -> None:
    fed = replace(pause, parameters={"motor.current": 2.0})
    (said,) = remarks(joined(fmus, fed), [fed])
    assert said == f"{LAW}: runs on its FMUs, since its joined system does not take the run that was tried"


def test_zig_compiles_joined_systems_where_there_is_no_other_compiler(
    pause: Scenario, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ziglang", reason='ziglang is not installed: pip install "warmlink[cross]"')
    case, whole = case_of(pause, ("lag",)), joined(fmus, pause)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compile.shutil, "which", lambda name: None)
    rollout = compiled(pause.joined({}), whole.rollouts[LAW].recorded)
    assert rollout.library != whole.rollouts[LAW].library
    assert joined_outcomes([case], {LAW: rollout})[0].max_abs_um == pytest.approx(
        joined_outcomes([case], whole.rollouts)[0].max_abs_um, rel=1e-9
    )


def test_it_is_said_that_the_score_of_the_run_which_was_tried_is_no_number(
    pause: Scenario, fmus: FmuSet
) -> None:
    root = Expression("sqrt(compensator.correction - link.elongation)")
    wild = replace(pause, machine=replace(pause.machine, roles=replace(pause.machine.roles, score=root)))
    (said,) = remarks(joined(fmus, wild), [wild])
    assert said == f"{LAW}: runs on its FMUs, since the score of the run that was tried of it is no number"
