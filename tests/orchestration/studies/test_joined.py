"""Runs of the joined system beside those of its FMUs."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.packaging.native import library
from warmlink.fmus.packaging.native import rollout as rollout_module
from warmlink.fmus.packaging.native.library import loaded
from warmlink.fmus.packaging.native.rollout import Given, Played, Rollout, task_list
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies import joined as runs
from warmlink.orchestration.studies import processes
from warmlink.orchestration.studies.case import METRICS, Case, case_of, figures
from warmlink.orchestration.studies.joined import agreeing, differences_from_fmus, joined_systems
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.workers import (
    FmuSet,
    attempt,
    attempt_all,
    groups,
    joined_outcomes,
)

LAWS = {"lag": "LagCompensator", "none": "NoCompensator"}


@pytest.fixture(scope="module")
def rollouts() -> dict[str, Rollout]:
    said: list[str] = []
    scenarios = [replace(load_scenario("stop_and_go"), controller=catalogue.shipped(law)) for law in LAWS]
    found = joined_systems(scenarios, said.append)
    assert said == []
    return found


def scenario(folder: Path, law: str = "lag", duty: str = "pause") -> Scenario:
    return replace(load_scenario(str(folder / f"{duty}.toml")), controller=catalogue.shipped(law))


def planned(folder: Path, *laws: str, **changed: object) -> list[Case]:
    return [
        case_of(
            replace(scenario(folder, law, duty), **changed).mismatched(mismatch.load(name)), (law, duty, name)
        )
        for law in laws
        for duty in ("work", "pause")
        for name in ("nominal", "noisy_sensors", "draw_1")
    ]


def test_figures_are_those_of_the_fmus_within_the_coupling_error(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    for name in ("nominal", "noisy_sensors", "thermal_low"):
        changed = scenario(folder).mismatched(mismatch.load(name))
        case = case_of(changed, ("lag", "pause", name), with_budget=True)
        exact, joined = attempt(case, fmus), joined_outcomes([case], rollouts)[0]
        assert exact.coupling_um is not None
        assert joined.coupling_um is not None
        assert joined.coupling_um < exact.coupling_um
        for figure in ("max_abs_um", "p95_abs_um", "rms_um"):
            assert abs(getattr(joined, figure) - getattr(exact, figure)) <= exact.coupling_um
        assert joined.max_abs_um != exact.max_abs_um
        assert joined.within_tolerance_min == pytest.approx(exact.within_tolerance_min, abs=0.1)
        assert joined.correction_rate_um_s == pytest.approx(exact.correction_rate_um_s, rel=1e-3)
        assert joined.leap_um == pytest.approx(exact.leap_um, rel=1e-3)
        assert joined.travel_um_h == pytest.approx(exact.travel_um_h, rel=1e-3)
        assert joined.ready_percent == pytest.approx(exact.ready_percent, abs=0.1)
        assert all(math.isfinite(of(joined, case)) for of in METRICS.values())


def test_a_run_is_the_same_alone_and_beside_others(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    cases = planned(folder, "lag", "none") * 2
    cases += [replace(each, step_size=2.0) for each in cases[:3]]
    cases += [
        replace(each, values={**each.values, "sensors": {**each.values["sensors"], "sample_time": 5.0}})
        for each in planned(folder, "lag")
        if "sensors" in each.values
    ]
    # Beside one that radiates, the others too take the step with all that is rare.
    cases.append(replace(cases[0], values={**cases[0].values, "link": {"emissivity": 0.3}}))
    together = replace(fmus, rollouts=rollouts)
    shares = groups(cases, rollouts)
    assert sorted(place for share in shares for place in share) == list(range(len(cases)))
    assert 1 < len(shares) < len(cases)
    alone = [joined_outcomes([case], rollouts)[0] for case in cases]
    assert attempt_all(cases, together) == alone
    assert len(set(alone)) > 9


@pytest.mark.parametrize("refused", [1.0, 0.5])
def test_what_an_fmu_would_refuse_at_either_step_is_run_on_the_fmus(
    folder: Path, rollouts: dict[str, Rollout], monkeypatch: pytest.MonkeyPatch, refused: float
) -> None:
    case = case_of(scenario(folder), ("lag", "pause", "nominal"), with_budget=True)
    run = Rollout.run

    def refusing(
        self: Rollout, given: Sequence[Given], count: int, step: float, played: Sequence[Played]
    ) -> object:
        values, well = run(self, given, count, step, played=played)
        return values, well & (step != refused * case.step_size)

    monkeypatch.setattr(Rollout, "run", refusing)
    assert joined_outcomes([case], rollouts) == {}


def test_runs_of_one_duty_share_its_table(folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]) -> None:
    cases = planned(folder, "lag")
    alone = [joined_outcomes([case], rollouts)[0] for case in cases]
    rollout_module._table.cache_clear()
    assert joined_outcomes(cases, rollouts) == dict(enumerate(alone))
    assert rollout_module._table.cache_info().misses == 2  # work and pause, each under three mismatches


def test_the_table_of_a_duty_has_a_row_for_each_change(
    folder: Path, rollouts: dict[str, Rollout], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not for each instant of a long run, of which many would not fit into memory."""
    made: list[np.ndarray] = []
    table = rollout_module._table
    monkeypatch.setattr(rollout_module, "_table", lambda *given: made.append(table(*given)) or made[-1])
    (case,) = (each for each in planned(folder, "lag") if each.label == ("lag", "pause", "nominal"))
    assert joined_outcomes([replace(case, stop_time=86400.0)], rollouts)
    assert all(each.nbytes < 1000 for each in made)


def test_processes_give_what_this_one_gives(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout], monkeypatch: pytest.MonkeyPatch
) -> None:
    cases, together = planned(folder, "lag"), replace(fmus, rollouts=rollouts)
    with LocalWorkers(together, 1) as workers:
        here = dict(workers.run(cases))
        monkeypatch.setattr(processes, "SOON_DONE_S", 0.0)
        there = dict(workers.run(cases))
    assert here == there
    assert len(here) == len(cases)


def test_what_an_fmu_refuses_is_told_by_the_fmus(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    good = planned(folder, "lag")[0]
    wrong = (
        ("motor", "standby_power", 1e307, "is not finite"),
        ("link", "conductivity", -1.0, "conductivity"),
        ("link", "base_position", 0.32, "leaves no length"),
    )
    cases = [good] + [
        replace(good, values={**good.values, part: {**good.values.get(part, {}), name: value}})
        for part, name, value, _ in wrong
    ]
    assert list(joined_outcomes(cases, rollouts)) == [0]
    found = attempt_all(cases, replace(fmus, rollouts=rollouts))
    assert found[0].stopped is None
    for outcome, (*_, said) in zip(found[1:], wrong, strict=True):
        assert said in str(outcome.stopped)


def test_an_input_that_nothing_feeds_has_the_value_that_a_run_gives_it(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    case = planned(folder, "lag")[0]
    warm, as_ever = (
        replace(case, values={**case.values, "motor": {**case.values.get("motor", {}), "current": current}})
        for current in (2.0, 0.0)
    )
    found = attempt_all([case, warm, as_ever], replace(fmus, rollouts=rollouts))
    assert found[1] == attempt(warm, fmus)
    assert abs(found[1].max_abs_um - found[0].max_abs_um) > 1
    assert found[2] == found[0]


def test_a_system_that_differs_from_its_fmus_is_refused(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    said: list[str] = []
    law = LAWS["lag"]
    duty = scenario(folder).mismatched(mismatch.load("nominal"))
    same = replace(fmus, rollouts={law: rollouts[law]})
    assert agreeing([duty], same, said.append) == same
    assert "figures differ by at most" in said[0]
    assert "the coupling error is up to" in said[0]
    other = replace(fmus, rollouts={law: rollouts[LAWS["none"]]})
    assert agreeing([duty], other, said.append).rollouts == {}
    assert "more than the coupling error" in said[1]
    assert "it runs on its FMUs" in said[1]


def test_what_is_tried_is_where_the_growth_turns_most_sharply(
    folder: Path, fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    def coupling(duties: list[str], names: list[str]) -> float:
        changed = [
            scenario(folder, "lag", duty).mismatched(mismatch.load(name)) for duty in duties for name in names
        ]
        lag = replace(fmus, rollouts={LAWS["lag"]: rollouts[LAWS["lag"]]})
        ((_, found),) = differences_from_fmus(changed, lag, print).values()
        return found

    names = ["nominal", "thermal_high", "insulated"]
    each = [coupling([duty], [name]) for duty in ("work", "pause") for name in names]
    assert coupling(["work", "pause"], names) == max(each)
    assert max(each) > 2 * each[0]


def test_the_coupling_error_counts_what_a_controller_makes_of_it(
    folder: Path, rollouts: dict[str, Rollout]
) -> None:
    """As where a thermometer rounds the growth's small error to a step of its readings."""
    case = case_of(scenario(folder), ("lag", "pause", "nominal"), with_budget=True)
    ((_, coarse, fine),) = runs.joined_results([case], rollouts)
    rounded = fine.table.values.copy()
    rounded[:, fine.table.names.index("compensator.correction")] += 1e-6
    moved = replace(fine, table=fine.table.holding(rounded))
    same, more = (figures(case, coarse, each).coupling_um or 0.0 for each in (fine, moved))
    assert same < 0.1
    assert more == pytest.approx(3.0, abs=0.1)


def test_what_cannot_be_joined_runs_on_fmus(folder: Path) -> None:
    duty = scenario(folder)
    said: list[str] = []
    assert joined_systems([replace(duty, master="jacobi")], said.append) == {}
    foreign = replace(duty.machine, foreign={"ThermalLink": Path("theirs.fmu")})
    assert joined_systems([replace(duty, machine=foreign)], said.append) == {}
    assert said == []


def test_runs_of_joined_systems_and_of_fmus_are_told_apart(
    fmus: FmuSet, rollouts: dict[str, Rollout]
) -> None:
    assert replace(fmus, rollouts=rollouts).digest != fmus.digest


def test_micro_steps_samples_and_records_come_in_the_order_of_an_fmu() -> None:
    tasks, times, steps = task_list(2, 1.0, (0.5, 2.0), 0.4)
    done = list(zip(tasks.tolist(), np.round(times, 9).tolist(), np.round(steps, 9).tolist(), strict=True))
    half = [(0, 0.0, 0.25), (0, 0.25, 0.25), (2, 0.5, 0.5), (0, 0.5, 0.25), (0, 0.75, 0.25), (2, 1.0, 0.5)]
    later = [(task, time + 1.0, step) for task, time, step in half]
    assert done == [(1, 0.0, 1.0), *half, (1, 1.0, 1.0), *later, (3, 2.0, 2.0), (1, 2.0, 1.0)]


@pytest.mark.parametrize("damage", ["unreadable", "another compiler"])
def test_a_kept_system_that_is_of_no_use_is_compiled_anew(
    damage: str, folder: Path, rollouts: dict[str, Rollout], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []
    rollout = rollouts[LAWS["lag"]]
    monkeypatch.setenv("WARMLINK_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(runs, "compiled", lambda *given: made.append(1) or rollout)
    for _ in range(2):
        assert joined_systems([scenario(folder)], print)[LAWS["lag"]].library == rollout.library
    assert len(made) == 1
    if damage == "unreadable":
        (file,) = (tmp_path / "cache" / "rollouts").glob("*.kept")
        file.write_bytes(hashlib.sha256(b"no pickle").digest() + b"no pickle")
    else:
        monkeypatch.setenv("CC", "gcc")
    assert joined_systems([scenario(folder)], print)[LAWS["lag"]].library == rollout.library
    assert len(made) == 2


def test_a_library_that_does_not_load_leaves_the_fmus(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(path: str) -> None:
        raise OSError("failed to map segment")

    loaded.cache_clear()
    monkeypatch.setattr(library.ctypes, "CDLL", refused)
    said: list[str] = []
    assert joined_systems([scenario(folder)], said.append) == {}
    assert "runs on its FMUs, since its system cannot be joined" in said[0]
    assert "failed to map segment" in said[0]
