"""FMUs in the loop: the same readings, derivatives and verdict as from the equations in one piece."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.own_systems import (
    CELL_CHANNELS,
    CELL_INPUTS,
    MACHINE_COLUMNS,
    cell,
    experiment,
    machine,
    measured,
    spindle,
    with_values,
    write_csv,
)
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.causes.declared import read_causes
from warmlink.orchestration.diagnosis.data.experiment import Experiment, calibrating
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import assess
from warmlink.orchestration.diagnosis.model import driven, loop
from warmlink.orchestration.machine.heat_paths import with_paths
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.system.model import DefaultExperiment

CAUSES = """
[[cause]]
name = "tube"
sentence = "A tube with air from the winding warms the link's tip."
check = "Close the tube."
adds = { conductance = "W/K", from = "motor.winding_temperature", to = "link.tip_temperature", \
into = "link.tip_heat_flow" }
between = ["0 W/K", "2 W/K"]
[[cause]]
name = "paint"
sentence = "The link is painted."
check = "Look at it."
frees = ["link.emissivity"]
between = [0, 1]
[[cause]]
name = "slow"
sentence = "The thermometer at the base follows late."
check = "Exchange it."
reading = { of = "link.base_temperature", lag = "s" }
between = ["0 s", "10 min"]
"""
FOR_A_COLUMN = "[[cause]]" + CAUSES.split("[[cause]]")[2].replace("link.", "column.")
CALIBRATED = '[calibrate]\n"link.convection_still" = { min = 1, max = 12, start = 5 }\n'
COLUMNS = {**CELL_INPUTS, **CELL_CHANNELS}


class Here(Executor):
    """Runs what it is given at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        done: Future[Any] = Future()
        done.set_result(fn(*args, **kwargs))
        return done


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run of a cell with a hidden tube."""
    monkeypatch.setattr(driven, "_pool", Here)
    (tmp_path / "causes.toml").write_text(CAUSES, "utf-8")
    changed, _ = with_paths(cell(), read_causes(tmp_path / "causes.toml").paths)
    truth = with_values(changed, {"tube": {"conductance": 0.1}})
    write_csv(measured(truth, COLUMNS, 0.05, 1), tmp_path / "run.csv")
    return tmp_path


def said(folder: Path, more: str) -> Experiment:
    return read([experiment(folder, cell(), COLUMNS, CAUSES, more)])


def test_readings_and_derivatives_are_those_of_the_joined_component(folder: Path) -> None:
    joined, looped = (Problem(said(folder, more)) for more in ("", "in_loop = true"))
    assert joined.slots == looped.slots
    z = joined.neutral[0].copy()
    assert np.array_equal(z, looped.neutral[0])
    for step in (0.0, 0.2):
        z[joined.slots.index("tube.conductance")] = step
        for each in (joined, looped):
            each.refine([z])
        ours, theirs = (each.predict(0, z) for each in (joined, looped))
        # Each step of either may err by 3 mK while the winding leaps; the noise is 50 mK.
        assert np.abs(ours[0] - theirs[0]).max() < 1e-2, "K"
        for i, slot in enumerate(joined.slots):
            size = np.abs(ours[1][:, :, i]).max()
            # Steps of 7.5 s blur a leap of the inputs, and the slopes in time that a lag goes by even more.
            share = 0.1 if slot.endswith("lag") else 0.03
            assert np.abs(ours[1][:, :, i] - theirs[1][:, :, i]).max() < share * size + 1e-9, slot


def test_rows_between_communication_points_are_not_late(folder: Path) -> None:
    path = folder / "run.csv"
    header, *rows = path.read_text("utf-8").splitlines()
    late = [float(row.partition(",")[0]) + 2.5 * (i > 0) for i, row in enumerate(rows)]
    moved = [f"{time},{row.partition(',')[2]}" for time, row in zip(late, rows, strict=True)]
    path.write_text("\n".join([header, *moved]), "utf-8")
    joined, looped = (Problem(said(folder, more)) for more in ("", "in_loop = true"))
    ours, theirs = (each.finest(0, each.neutral[0]) for each in (joined, looped))
    assert np.abs(ours - theirs).max() < 1e-2, "K"


def test_fmus_communicate_at_the_rows_unless_one_allows_no_uneven_steps() -> None:
    rows = np.array([0.0, 7.0, 20.0])
    uneven = loop._communication(rows, 5.0, uneven=True)
    assert uneven == pytest.approx([0, 3.5, 7, 7 + 13 / 3, 7 + 26 / 3, 20])
    assert loop._communication(rows, 5.0, uneven=False).tolist() == [0, 5, 10, 15, 20]
    assert driven.halved(uneven)[::2].tolist() == uneven.tolist()


def test_where_only_instruments_may_be_wrong_there_is_nothing_to_differentiate(folder: Path) -> None:
    found = Problem(said(folder, "in_loop = true"))
    run = found.experiment.runs[0]
    nothing = np.empty(0)
    simulated = loop.Loop(found.experiment.rig, (), found.variables, run, {}, None, (nothing, nothing))
    simulated.refine(nothing)
    assert simulated(nothing, run.time).by_slot.shape == (run.time.size, len(found.variables), 0)


def test_what_is_done_with_leaves_nothing_behind(folder: Path) -> None:
    found = Problem(said(folder, "in_loop = true"))
    found.refine(found.neutral)
    watched = weakref.ref(found)
    gc.disable()
    try:
        del found
        assert watched() is None
    finally:
        gc.enable()


def test_a_value_that_is_no_number_stays_where_it_is(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An FMU may give such an output at its first communication point."""
    found = Problem(said(folder, "in_loop = true"))
    run, nothing = found.experiment.runs[0], np.empty(0)
    simulated = loop.Loop(found.experiment.rig, (), found.variables, run, {}, None, None)
    course = np.full((simulated.time.size, len(found.variables)), 300.0)
    course[0] = np.nan
    monkeypatch.setattr(loop, "courses", lambda runs: [course, np.repeat(course, 2, axis=0)[:-1]])
    values = simulated(nothing, simulated.time).values
    assert np.isnan(values[0]).all()
    assert np.isfinite(values[2:]).all()


def test_in_a_loop_the_same_cause_is_named(folder: Path) -> None:
    found = [assess(said(folder, more)) for more in ("", "in_loop = true")]
    assert [each.word for each in found] == ["named", "named"]
    joined, looped = (each.best for each in found)
    assert (joined.name, looped.name) == ("tube", "tube")
    assert looped.theta[0] == pytest.approx(joined.theta[0], abs=0.1 * np.sqrt(joined.covariance()[0, 0]))
    assert looped.covariance()[0, 0] == pytest.approx(joined.covariance()[0, 0], rel=0.05)


def watched(seen: list[bool]) -> Callable[..., Result]:
    """The master, which notes whether it stepped in compiled code."""

    def run(*args: Any, **options: Any) -> Result:
        found = simulate(*args, **options)
        seen.append(found.statistics.compiled)
        return found

    return run


def test_the_compiled_loop_reads_the_log_as_the_plain_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = Problem(said(folder, "in_loop = true"))
    made: list[driven.Driven] = []
    monkeypatch.setattr(loop, "courses", lambda runs: made.extend(runs) or [driven._course(r) for r in runs])
    found.finest(0, found.neutral[0])
    assert "motor.speed" in made[0].signals
    seen: list[bool] = []
    monkeypatch.setattr(driven, "simulate", watched(seen))
    compiled = driven._course(made[0])
    monkeypatch.setattr("warmlink.orchestration.master.run.choose", lambda *_: False)
    plain = driven._course(made[0])
    assert seen == [True, False]
    assert np.array_equal(compiled, plain)
    assert np.ptp(compiled[:, 0]) > 5, "K"


def test_a_part_that_nobody_knows_is_simulated_in_a_loop(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.machine.read.is_ours", lambda fmu, _: "Link" not in fmu.name)
    found = Problem(said(folder, CALIBRATED))
    rig = found.experiment.rig
    assert rig.in_loop
    assert set(rig.foreign) == {"link"}
    assert "link.convection_still" in found.slots
    assert rig.unit("link.conductivity") == "W/(m.K)"
    assert rig.variables["link.base_temperature"].is_temperature


def test_a_foreign_fmu_is_calibrated(folder: Path) -> None:
    base = machine(spindle(folder))
    base = replace(base, default_experiment=DefaultExperiment(0.0, 1200.0, 10.0))
    truth = with_values(base, {"spindle": {"friction": 2.6}})
    write_csv(measured(truth, MACHINE_COLUMNS, 0.05, 1, step=1.0), folder / "run.csv")
    asked = '[calibrate]\n"spindle.friction" = { min = 1, max = 5, start = 2 }\n'
    path = experiment(folder, base, MACHINE_COLUMNS, FOR_A_COLUMN, asked)
    found = diagnose_experiment(calibrating(read([path])))
    rig = found.experiment.rig
    assert set(rig.foreign) == {"spindle"}
    assert "spindle.speed" in rig.externals, "though the duty cycle's FMU feeds it in the system"
    (friction,) = calibration(found)
    assert abs(friction.value - 2.6) < 4 * friction.std
    assert friction.std < 0.05


def test_rows_hours_apart_take_no_more_steps_than_they_need(folder: Path) -> None:
    """The inputs are held for an hour at a time, and the system proposes steps of 5 s."""
    time = 3600.0 * np.arange(24.0)
    columns = {
        "time [s]": time,
        "speed [1]": np.round(3 + 3 * np.sin(time / 1e4)),
        "room [degC]": 21 + 0 * time,
    }
    temperatures = {header: 22 + 0 * time for header in MACHINE_COLUMNS if header not in columns}
    write_csv({**columns, **temperatures, "spindle [1]": 295.15 + 0 * time}, folder / "run.csv")
    slow = {"capacity": 4e5, "friction": 20.0}
    base = with_values(machine(spindle(folder)), {"spindle": slow})
    path = experiment(folder, base, MACHINE_COLUMNS, FOR_A_COLUMN)
    found = Problem(read([path]))
    run, z = found.experiment.runs[0], found.neutral[0][: len(found.inner)]
    rig, known = found.experiment.rig, found.known(run)
    parts = rig, found.inner, found.variables, run, known, None, None
    sought, fine = loop.Loop(*parts), loop.Loop(*parts, 5.0)
    assert 5.0 < sought.step <= 900.0
    assert sought.time.size < fine.time.size / 2
    theirs, ours = (each(z, run.time).values for each in (sought, fine))
    assert np.all(np.abs(theirs - ours).max(axis=0) <= 1e-3 * np.ptp(ours, axis=0))
    assert np.ptp(ours) > 3, "K, so that there was something to get wrong"
    close = replace(run, time=run.time / 360)
    assert loop.Loop(*parts[:3], close, *parts[4:]).step == 5.0, "where rows are close the system's own"
