import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.documented import undescribed
from tests.pages import plots
from warmlink.fmus.errors import InputError
from warmlink.orchestration.report.studies import MOST_FAILED, UNITS, write_sweep
from warmlink.orchestration.studies.case import METRICS, Case, Constraint, Gathered, Outcome
from warmlink.orchestration.studies.points import Judged, Searched, best, front
from warmlink.orchestration.studies.study import Study, SweepSettings, load_study
from warmlink.orchestration.studies.sweep import Swept, points_of, sweep
from warmlink.orchestration.studies.workers import FmuSet

from .conftest import Here


@pytest.fixture
def study(folder: Path) -> Study:
    return load_study(str(folder / "study.toml"))


def test_a_grid_holds_every_combination_in_order(study: Study) -> None:
    points = points_of(study)
    gains = [point["compensator.gain"] for point in points]
    times = [point["compensator.time_constant"] for point in points]
    assert gains == pytest.approx(np.repeat([2e-6, 5e-6, 8e-6], 3))
    assert times == pytest.approx(np.tile([600.0, (600 * 7200) ** 0.5, 7200.0], 3))


def test_a_hypercube_has_one_point_in_each_stratum_of_each_axis(study: Study) -> None:
    study = replace(study, sweep=SweepSettings("latin_hypercube", 40))
    points = points_of(study)
    assert points == points_of(study)
    assert points != points_of(replace(study, seed=9))
    gains = np.array([point["compensator.gain"] for point in points])
    logs = np.log([point["compensator.time_constant"] for point in points])
    for values, low, high in ((gains, 2e-6, 8e-6), (logs, np.log(600), np.log(7200))):
        strata = np.floor(40 * (values - low) / (high - low)).astype(int)
        assert sorted(strata) == list(range(40))


def test_a_grid_that_nobody_can_mean_is_refused(study: Study) -> None:
    with pytest.raises(InputError, match="a grid of 4000000 points"):
        points_of(replace(study, sweep=SweepSettings("grid", 2000)))


def test_the_table_has_a_row_a_run(study: Study, fmus: FmuSet, tmp_path: Path) -> None:
    import pandas as pd

    points = [*points_of(study)[:2], {**points_of(study)[2], "compensator.time_constant": -1.0}]
    found = sweep(study, points, Here(fmus), lambda done: None)
    Swept(study, found).write(tmp_path / "sweep.parquet")
    frame = pd.read_parquet(tmp_path / "sweep.parquet")
    assert list(frame["point"]) == [0, 0, 1, 1, 2, 2]
    assert not undescribed("sweep.parquet", dict.fromkeys(frame))
    assert list(frame["duty_cycle"]) == ["work", "pause"] * 3
    assert frame["compensator.gain [m/W]"].to_numpy() == pytest.approx([2e-6] * 6)
    assert frame["max_abs_um"][:4].notna().all()
    assert frame["objective"][0] == frame["max_abs_um"][:2].max()
    assert frame["max_abs_um"][4:].isna().all()
    assert frame["reason"][:4].isna().all()
    assert frame["reason"][4] == "compensator.time_constant: -1 s is not positive; give a value above 0 s"
    assert list(frame["feasible"][4:]) == [False, False]
    write_sweep(study, found, tmp_path / "report.html")
    assert "Points without an objective" in (tmp_path / "report.html").read_text()
    drawn = plots(tmp_path / "report.html")
    # Numbers of some 1e-6 m/W are shown in a unit that they are read in, over an axis and in the overview.
    assert drawn.count('"gain [\\u00b5m\\u002fW]"') == 2


def test_points_are_laid_out_a_share_at_a_time(
    study: Study, fmus: FmuSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = sweep(study, points_of(study), Here(fmus), lambda done: None)
    asked: list[int] = []

    class Counted(Here):
        def run(self, cases: Sequence[Case]) -> Iterator[tuple[int, Outcome]]:
            asked.append(len(cases))
            return super().run(cases)

    monkeypatch.setattr("warmlink.orchestration.studies.sweep.AT_ONCE", 4)
    done: list[int] = []
    assert sweep(study, points_of(study), Counted(fmus), done.append) == whole
    assert asked == [8, 8, 2]
    assert done == list(range(1, 10))


def test_two_objectives_are_both_in_the_answer_the_table_and_the_page(
    study: Study, fmus: FmuSet, tmp_path: Path
) -> None:
    import pandas as pd

    two = replace(study, objectives=(*study.objectives, Gathered("correction_rate_um_s")), constraints=())
    found = sweep(two, points_of(two), Here(fmus), lambda done: None)
    kept, winner = front(found), best(found)
    assert winner is not None
    told = Searched(two, found).summary()
    assert len(kept) > 2
    assert "smallest" not in told
    assert f"amid the front: {winner.objective:.4g}, point {winner.number}" in told
    assert "front, by worst max_abs_um and worst correction_rate_um_s" in told
    assert all(re.search(rf"^  point {each.number} .*{each.objective:.4g}", told, re.M) for each in kept)
    Swept(two, found).write(tmp_path / "sweep.parquet")
    frame = pd.read_parquet(tmp_path / "sweep.parquet")
    assert not undescribed("sweep.parquet", dict.fromkeys(frame))
    assert list(frame["second_objective"][::2]) == [each.objectives[1] for each in found]
    write_sweep(two, found, tmp_path / "report.html")
    assert "The points that no other one betters in both objectives" in (tmp_path / "report.html").read_text()


def test_it_is_said_that_no_point_keeps_every_constraint(study: Study, fmus: FmuSet) -> None:
    strict = replace(study, constraints=(Constraint("rms_um", at_most=0.0),))
    found = sweep(strict, points_of(strict)[:2], Here(fmus), lambda done: None)
    summary = Searched(strict, found).summary()
    close = min(found, key=lambda each: each.excess)
    assert "no point keeps every constraint" in summary
    missed = f"worst rms_um {close.excess[0]:.4g}, {close.excess[0]:.4g} above 0"
    assert f"nearest is point {close.number}: {missed}" in summary


def test_parameters_of_one_name_both_have_an_axis(study: Study, fmus: FmuSet, tmp_path: Path) -> None:
    names = "sensors.sample_time", "compensator.sample_time"
    axes = tuple(replace(study.axes[0], name=name, unit="s", low=1.0, high=2.0) for name in names)
    both = replace(study, axes=axes)
    write_sweep(both, sweep(both, points_of(both)[:2], Here(fmus), lambda done: None), tmp_path / "a.html")
    dimensions = re.findall(r'"label": ?"sample_time', plots(tmp_path / "a.html"))
    assert len(dimensions) == 2


def test_what_a_page_leaves_out_is_said(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.report.studies.MOST_LINES", 3)
    point = points_of(study)[0]
    found = [Judged(number, point, (float(number),), (0.0,)) for number in range(4)]
    found += [Judged(1000 + number, point, reason="it broke") for number in range(MOST_FAILED + 7)]
    write_sweep(study, found, tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text("utf-8")
    assert "The first 3 of 4 points; the table beside this page holds them all." in text
    assert f"The first {MOST_FAILED} of {MOST_FAILED + 7}." in text
    assert ">1000<" in text
    assert "600 to 7200 s, on a logarithmic scale" in text
    write_sweep(study, found[:3], tmp_path / "b.html")
    assert "The first" not in (tmp_path / "b.html").read_text("utf-8")


@pytest.mark.parametrize("metric", METRICS)
def test_the_unit_of_every_metric_is_known(metric: str) -> None:
    assert any(metric.endswith(f"_{end}") for end in UNITS)
