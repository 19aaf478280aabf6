import csv
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controller, shipped
from warmlink.orchestration.cli import main
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.outcome import run_scenario
from warmlink.orchestration.command_line.comparison import legend, table
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.mismatch import Mismatch
from warmlink.orchestration.scenarios.overrides import StartValueSet, assigned, reached_controllers
from warmlink.orchestration.scenarios.scenario import changed
from warmlink.orchestration.studies.case import Case, Outcome
from warmlink.orchestration.studies.compare import (
    COLUMNS,
    Comparison,
    plan,
    plan_on,
    run_comparison,
    write_csv,
)
from warmlink.orchestration.studies.processes import LocalWorkers
from warmlink.orchestration.studies.workers import FmuSet
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit

from .conftest import Here


def cases(folder: Path, *wrong: str) -> list[Case]:
    duties = [load_scenario(str(folder / name)) for name in ("work.toml", "pause.toml")]
    return plan([shipped("lag")], duties, [mismatches.load(name) for name in wrong]).cases


def comparison(folder: Path, fmus: FmuSet, *wrong: str) -> Comparison:
    return run_comparison(cases(folder, *wrong), Here(fmus), lambda share: None)


def test_figures_are_those_of_warmlink_run(folder: Path, fmus: FmuSet) -> None:
    row = comparison(folder, fmus, "nominal").row("lag", "work")
    outcome = run_scenario(load_scenario(str(folder / "work.toml")), FmuStore(fmus.kind))
    assert row.outcome.max_abs_um == outcome.metrics.max_abs_um
    assert row.outcome.p95_abs_um == outcome.metrics.p95_abs_um
    assert row.outcome.time_to_tolerance_s == outcome.metrics.time_to_tolerance_s
    assert row.uncompensated_um == outcome.uncompensated.max_abs_um
    assert row.removed_percent == outcome.to_dict()["reduction_percent"]
    assert row.equal_within_um is not None
    assert outcome.coupling_error_um is not None
    budget = outcome.coupling_error_um + outcome.discretisation_error_um
    assert row.equal_within_um == pytest.approx(budget)


def test_rows_are_the_same_whatever_the_number_of_workers(folder: Path, fmus: FmuSet) -> None:
    planned = cases(folder, "nominal", "draw_4")
    here = run_comparison(planned, Here(fmus), lambda share: None)
    shares: list[float] = []
    with LocalWorkers(fmus, 2) as workers:
        there = run_comparison(planned, workers, shares.append)
    assert here == there
    assert list(here.rows) == [(case.label[0], case.label[1], case.label[2]) for case in planned]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_the_table_has_the_columns_that_others_read(folder: Path, fmus: FmuSet, tmp_path: Path) -> None:
    found = comparison(folder, fmus, "nominal", "camera_absent")
    write_csv(found, tmp_path / "compare.csv")
    with (tmp_path / "compare.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == COLUMNS
    assert [row["controller"] for row in rows] == ["none"] * 4 + ["lag"] * 4
    assert {row["mismatch"] for row in rows} == {"nominal", "camera_absent"}
    assert [float(row["removed_percent"]) for row in rows[:4]] == [0.0] * 4
    # The elongation is that of the nominal cell, and so is its budget.
    assert rows[0]["equal_within_um"] == rows[1]["equal_within_um"] != ""


def made(
    scores: dict[str, float], budget: float, mismatch: str = "nominal", tolerance: float = 5e-6
) -> Comparison:
    def outcome(score: float, budget: float | None = None) -> Outcome:
        return Outcome(score, score, score, None, 30.0, 20.0, 0.1, 0.0, budget)

    planned = [
        Case((name, "work", mismatch), name, {}, 3600.0, 1.0, "gauss_seidel", tolerance) for name in scores
    ]

    class Given:
        def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Any]]:
            for i, case in enumerate(cases):
                score = scores[case.label[0]]
                found = outcome(score, budget if case.label[0] == "none" else None)
                yield i, found if score == score else Outcome(stopped="the slave stopped")

    return run_comparison(planned, Given(), lambda share: None)


def test_scores_within_the_budget_are_equal() -> None:
    found = made({"none": 50.0, "a": 3.00, "b": 3.05, "c": 3.2}, 0.1)
    equal = {
        name: found.row(name, "work").equals(found.best_um("work", "nominal")) for name in found.controllers
    }
    assert equal == {"none": False, "a": True, "b": True, "c": False}


def test_a_defeat_is_marked() -> None:
    found = made(
        {"none": 8.0, "good": 4.0, "outside": 6.0, "equal": 8.05, "harm": 9.0, "x": float("nan")}, 0.1
    )
    rows = {name: found.row(name, "work") for name in found.controllers}
    assert [name for name, row in rows.items() if row.defeated] == ["none", "outside", "equal", "harm", "x"]
    assert [name for name, row in rows.items() if row.worse_than_none] == ["harm"]
    shown = dict(zip(found.controllers, table(found)[1][1:], strict=True))
    assert str(shown["good"]).split() == ["4.0", "50", "%", "*"]
    assert str(shown["outside"]).split() == ["6.0", "25", "%", "!"]
    assert str(shown["harm"]).split() == ["9.0", "-12", "%", "!!"]
    assert str(shown["x"]).split() == ["stopped", "!!"]


def test_each_figure_of_the_worst_says_which_mismatch_it_is_of() -> None:
    """The worst of `none` may be under another mismatch than that of a controller."""
    parts = [
        made({"none": none, "lag": lag}, 0.1, mismatch)
        for mismatch, none, lag in (("nominal", 8.0, 4.0), ("warm", 24.5, 9.0), ("noisy", 20.9, 105.9))
    ]
    rows = {key: row for part in parts for key, row in part.rows.items()}
    found = Comparison(("none", "lag"), ("work",), ("nominal", "warm", "noisy"), rows)
    shown = [[str(cell) for cell in row] for row in table(found)]
    assert shown[1] == ["  work", "8.0", "4.0  50 % *  "]
    assert shown[2][0] == "worst of 2 mismatches"
    assert [each.split() for each in shown[3][1:]] == [["24.5", "(1)"], ["105.9", "(2)", "-407", "%", "!!"]]
    assert legend(found).splitlines()[1] == (
        "(1) warm  (2) noisy: mismatch of the figure; a share is of no compensation under the same mismatch"
    )


def test_the_command_writes_table_and_report(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    arguments = ["compare", "--controllers", "lag", "--duty-cycles", "work.toml,pause.toml"]
    arguments += ["--mismatch", "nominal,thermal_low", "--out", "here"]
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert "worse than no compensation" in shown
    assert "thermal_low" in shown
    assert len((folder / "here" / "compare.csv").read_text().splitlines()) == 1 + 2 * 2 * 2
    assert "Productive minutes won" in (folder / "here" / "report.html").read_text()
    assert "heatmap" in plots(folder / "here" / "report.html")

    monkeypatch.setattr("sys.argv", ["warmlink", *arguments, "--json", "--no-report"])
    with pytest.raises(SystemExit):
        main()
    rows = json.loads(capsys.readouterr().out)
    assert [row["controller"] for row in rows] == ["none"] * 4 + ["lag"] * 4
    assert all(row["productive_minutes_won"] is not None for row in rows)


def test_start_values_go_to_the_controllers_that_have_them(folder: Path) -> None:
    laws = {name: controller(name) for name in ("none", "lag", "observer")}
    sets = [
        StartValueSet("--set a", {"link.length": "34 cm"}),
        StartValueSet("--set b", {"compensator.gain": "5 um/W"}),
        StartValueSet("--parameters c.ssv", {"compensator.gate": 4.0, "compensator.sample_time": 2.0}),
        StartValueSet("--set d", {"link.length": "35 cm"}),
    ]
    values = assigned(sets, laws)
    assert values["none"] == {"link.length": "35 cm"}
    assert values["lag"] == {"link.length": "35 cm", "compensator.gain": "5 um/W"}
    assert values["observer"] == {
        "link.length": "35 cm",
        "compensator.gate": 4.0,
        "compensator.sample_time": 2.0,
    }
    assert [reached_controllers(each, laws) for each in sets] == [
        None,
        "--set b: for lag",
        "--parameters c.ssv: for observer",
        None,
    ]
    duties = [load_scenario(str(folder / "work.toml"))]
    wrong = [Mismatch("longer", "", {"link.length": 1.1})]
    planned = plan([shipped("lag"), shipped("observer")], duties, wrong, sets)
    cases = {case.label[0]: case.values for case in planned.cases}
    assert cases["none"]["link"]["length"] == pytest.approx(0.385)
    assert cases["lag"]["compensator"]["gain"] == pytest.approx(5e-6)
    assert cases["observer"]["compensator"]["sample_time"] == 2.0


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("compensator.gian", r"no controller compared has compensator.gian; did you mean gain\?"),
        ("compensator.gate", "or compare the controller that it is for"),
    ],
)
def test_start_values_that_no_controller_has_are_refused(name: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        assigned([StartValueSet("--set x", {name: 1.0})], {"lag": controller("lag")})


def test_the_command_takes_parameter_sets(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    gain = SsvValue("gain", "Real", 0.0, parse_unit("m/W"))
    write_ssv({"gain": gain}, folder / "off.ssv", "lag, off")
    command = ["compare", "--controllers", "lag", "--duty-cycles", "work.toml", "--mismatch", "nominal"]
    extra = ["--parameters", "off.ssv", "--set", "motor.joint_conductance=0.5 W/K", "--no-report", "--json"]
    monkeypatch.setattr("sys.argv", ["warmlink", *command, *extra])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    assert stop.value.code == 0, err
    assert "warmlink: --parameters off.ssv: for lag\n" in err
    without, lag = json.loads(out)
    assert lag["max_abs_um"] == without["max_abs_um"]
    # A worse joint lets less heat into the link: at nominal parameters it grows by 14 um.
    assert without["max_abs_um"] < 12.0


def test_it_is_said_that_steps_do_not_follow_a_coupling_tolerance(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    (folder / "cell.toml").write_text('duty = "work.toml"\ncoupling_tolerance = "0.01 um"\n')
    arguments = ["compare", "--scenario", "cell.toml", "--controllers", "none", "--mismatch", "nominal"]
    monkeypatch.setattr("sys.argv", ["warmlink", *arguments, "--no-report"])
    with pytest.raises(SystemExit):
        main()
    assert "coupling_tolerance: steps follow it in `warmlink run` alone" in capsys.readouterr().err


def test_what_is_set_is_set_in_the_cell_that_differs_as_in_a_run() -> None:
    """A conductivity that was set took the place of that of the cell's own draw."""
    given = {"link.conductivity": 100.0, "compensator.tolerance": 4e-6}
    plan = plan_on("WarmupCell", ["observer"], ["warm_up"], ["nominal"], [StartValueSet("given", given)])
    run = changed(load_scenario("warm_up"), "observer", given)
    assert plan.scenarios[-1].parameters == run.parameters
    assert plan.scenarios[-1].as_believed.parameters == run.as_believed.parameters
