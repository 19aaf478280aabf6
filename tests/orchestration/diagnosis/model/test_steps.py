"""The steps of a simulation meet their tolerance on the inputs as a logger wrote them."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.hidden_effects import KNOWN, drawn_duty, over_a_decade
from tests.orchestration.diagnosis.loggers import HALF, Logger, logged_file, logged_run
from warmlink.orchestration.arm.chain import axis
from warmlink.orchestration.diagnosis.answer.separation import run_of
from warmlink.orchestration.diagnosis.data.experiment import calibrating, read_experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.fit import problem as made_ready
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import assess
from warmlink.orchestration.diagnosis.model.equations import Equations
from warmlink.orchestration.diagnosis.model.forward import Forward
from warmlink.orchestration.diagnosis.model.steps import FINAL, SEARCH, Levels, Resolution
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.machine.rig import PLACE, rig
from warmlink.orchestration.scenarios.duties.duty import Segment

BASE_AND_SHAFT = ("link.base_temperature", "motor.shaft_temperature")
CELLS = 20

LOGGERS = {
    "rows as the clock has them": Logger(),
    "uneven rows": Logger(jitter=2.4),
    "a room that wanders": Logger(interval=15.0, room=0.4),
    "a pad that is regulated": Logger(jitter=1.0, pad_noise=0.2),
    "all at once": Logger(interval=8.0, jitter=3.0, room=0.8, pad_noise=0.1),
}


def course(run: Run, resolution: Resolution) -> np.ndarray:
    simulated = Forward(Equations(rig("WarmupCell", CELLS), [], BASE_AND_SHAFT), run, {}, resolution)
    return simulated(simulated.start_values(), run.time).values


def finest(run: Run) -> np.ndarray:
    """Simulated in steps of half a second: off by 1 mK at most."""
    cells = Equations(rig("WarmupCell", CELLS), [], BASE_AND_SHAFT)
    simulated = Forward(cells, run, {}, Resolution(CELLS, 0.5, 0, 0.5, np.inf))
    return simulated(simulated.start_values(), run.time).values


@pytest.mark.parametrize("name", LOGGERS)
def test_base_and_shaft_are_right_whatever_the_logger(name: str) -> None:
    run = logged_run(LOGGERS[name], seed=3, duty=HALF)
    exact = finest(run)
    for resolution, most, ordinary in ((SEARCH, 0.06, 0.01), (FINAL, 0.02, 0.002)):
        error = course(run, resolution) - exact  # K
        assert np.abs(error).max() < most
        assert np.sqrt(np.mean(error**2, axis=0)).max() < ordinary


def test_of_an_hourly_log_fewer_steps_are_as_right() -> None:
    hours, drawn = np.arange(0.0, 24.0), np.random.default_rng(5)
    levels = {
        "motor.speed": drawn.uniform(0.0, 4.0, hours.size),
        "motor.torque": drawn.uniform(0.0, 4.0, hours.size),
        "motor.ambient_temperature": 295.15 + drawn.uniform(-3.0, 3.0, hours.size),
    }
    hourly = Run("hourly", 3600 * hours, levels, {})
    minutes = np.arange(0.0, 3600 * hours[-1] + 1, 60.0)
    each_minute = Run("each minute", minutes, {n: v[hourly.row_at(minutes)] for n, v in levels.items()}, {})
    cells = Equations(rig("WarmupCell", CELLS), [], BASE_AND_SHAFT)

    def simulated(run: Run, resolution: Resolution) -> Forward:
        return Forward(cells, run, {}, resolution)

    fine = simulated(each_minute, Resolution(CELLS, 5.0, 0, 5.0, np.inf))
    exact = fine(fine.start_values(), hourly.time).values
    for resolution, most in ((SEARCH, 0.06), (FINAL, 0.003)):
        few, many = simulated(hourly, resolution), simulated(each_minute, resolution)
        assert few.time.size < many.time.size / 2
        assert np.abs(few(few.start_values(), hourly.time).values - exact).max() < most


def test_a_link_measured_from_end_to_end_takes_no_shorter_steps() -> None:
    """Beyond base and tip the stretches are then thin, and settle within any step."""
    time = np.arange(0.0, 3600.0, 10.0)
    room = 295.15 + 0.06 * np.random.default_rng(7).integers(-2, 3, time.size)
    run = Run("rod", time, {"heater.on": (time < 1800) * 1.0, "link.ambient_temperature": room}, {})
    sensor = ("link.sensor_temperature[2]",)
    length = {"link.length": 0.3, "heater.power": 8.0}

    def rod(base: float, tip: float, resolution: Resolution) -> Forward:
        place = {"link.base_position": base, "link.tip_position": tip, "link.sensor_position[2]": 0.15}
        return Forward(Equations(rig("BenchRod", CELLS), [], sensor), run, length | place, resolution)

    whole, inside = rod(0.0, 0.3, SEARCH), rod(0.01, 0.29, SEARCH)
    assert whole.time.size < 1.5 * inside.time.size
    fine = rod(0.0, 0.3, Resolution(CELLS, 0.5, 0, 0.5, np.inf))
    error = [each(each.start_values(), time).values for each in (whole, fine)]
    assert np.abs(error[0] - error[1]).max() < 0.06


def test_the_ends_of_a_link_are_right_between_steps_too() -> None:
    """Their cells have hardly any mass: their slopes are what is left of settling, and foretell nothing."""
    wrist = axis(6)
    known = {f"motor.{name}": value for name, value in wrist.motor.items()}
    known |= {f"link.{name}": value for name, value in wrist.link.items()}
    random = np.random.default_rng(0)
    jobs = [Segment(float(random.integers(5, 200)), *random.uniform(0.0, (1.9, 1.0))) for _ in range(8)]
    run = run_of(jobs, rig("WarmupCell"), [], 1.0, 5.0)
    slots = ["link.emissivity", *(f"{PLACE}:link.sensor_position[{i}]" for i in (1, 3))]
    outputs = ("link.base_temperature", "link.tip_temperature")
    ends = Equations(rig("WarmupCell", CELLS), slots, outputs)
    both = [Forward(ends, run, known, each) for each in (SEARCH, Resolution(CELLS, 0.5, 0, 0.5, np.inf))]
    ours, exact = (each(each.start_values(), run.time) for each in both)
    assert np.abs(ours.values - exact.values).max() < 0.02
    radiated = exact.by_slot[:, :, 0]
    assert np.abs(ours.by_slot[:, :, 0] - radiated).max() < 0.02 * np.abs(radiated).max()


@pytest.mark.parametrize(("resolution", "most"), [(SEARCH, 0.02), (FINAL, 0.0015)])
def test_between_steps_the_ends_of_a_link_are_as_right_as_its_middle(
    resolution: Resolution, most: float
) -> None:
    duty = Segment(900, 3.43, 2.5), Segment.with_pad(1500, 330.0), Segment(600, 0.0, 4.0)
    run = run_of(duty, rig("WarmupCell"), [], 1.0, 3.0)
    known = {"link.length": 0.3, "link.base_position": 0.0, "link.tip_position": 0.3}
    ends = Equations(
        rig("WarmupCell", resolution.cells), [], ("link.base_temperature", "link.tip_temperature")
    )
    each = (Forward(ends, run, known, g) for g in (resolution, Resolution(CELLS, 0.5, 0, 0.5, np.inf)))
    ours, exact = (simulated(simulated.start_values(), run.time).values for simulated in each)
    assert np.abs(ours - exact).max() < most, "K"


def test_a_discrete_input_is_never_averaged() -> None:
    """Two means of equal values by weights that sum to a little more than one, and one of unequal values."""
    time = np.array([0.0, 9.59, 22.08, 30.3])
    inputs = np.array([[2.0, 2.0, 2.0, 0.0], [21.9, 22.0, 22.1, 22.1]])
    levels = Levels(time, inputs, np.array([True, False]))
    (joined,), (there,) = levels.mean(levels.steps(np.array([0.0, 30.3])))
    assert there
    assert joined[0] == 2.0
    assert joined[1] == pytest.approx(21.998, abs=0.01)
    switched = Levels(time, inputs[:, [0, 3, 2, 1]], np.array([True, False]))
    assert not switched.mean(switched.steps(np.array([0.0, 30.3])))[1]


def test_a_step_that_errs_is_cut_in_two() -> None:
    run = logged_run(LOGGERS["uneven rows"], seed=4)
    exact = finest(run)
    coarse = Resolution(CELLS, 60.0, 0.0, 60.0, np.inf)
    before = np.abs(course(run, coarse) - exact).max()
    after = np.abs(course(run, Resolution(CELLS, 60.0, 0.0, 60.0, 0.005)) - exact).max()
    assert before > 0.15
    assert after < 0.015


def test_too_coarse_a_simulation_is_noticed_and_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(made_ready, "FINAL", Resolution(CELLS, 60.0, 0.0, 60.0, np.inf))
    problem = Problem(read_experiment(logged_file(tmp_path, {}, LOGGERS["uneven rows"], seed=5)))
    white = [NoiseModel(0.08 if "temperature" in v else 4e-7, 0.0, 60.0) for v in problem.variables]
    coarse = problem.finest(0, problem.neutral[0])
    assert problem.artefact(problem.neutral, white) > 3
    replaced = problem.finest(0, problem.neutral[0])
    assert np.abs(replaced - coarse)[:, 0].max() > 0.05
    problem.refine(problem.neutral)
    resolved = problem.finest(0, problem.neutral[0])
    monkeypatch.setattr(made_ready, "FINAL", Resolution(made_ready.CHECK_CELLS, 0.5, 0.01, 5.0, 1e-3))
    exact = Problem(problem.experiment).finest(0, problem.neutral[0])
    for channel in range(exact.shape[1]):
        left, was = (np.linalg.norm((each - exact)[:, channel]) for each in (resolved, replaced))
        assert left < was, problem.variables[channel]


def test_what_the_steps_leave_unresolved_is_taken_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = Problem(read_experiment(logged_file(tmp_path, {}, Logger(), seed=5)))
    at = problem.neutral[0]
    before = problem.finest(0, at)
    problem.refine(problem.neutral)
    after = problem.finest(0, at)
    monkeypatch.setattr(made_ready, "FINAL", Resolution(FINAL.cells, 0.5, 0.01, 2.5, 1e-4))
    exact = Problem(problem.experiment).finest(0, at)
    for channel in range(before.shape[1]):
        left, was = (np.linalg.norm((each - exact)[:, channel]) for each in (after, before))
        assert left < was / 3, problem.variables[channel]


@pytest.mark.parametrize("name", ["a room that wanders", "a pad that is regulated", "all at once"])
def test_where_a_fit_ends_readings_are_right_to_a_fraction_of_their_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Where the pad stops giving all it can, the course has a kink: elsewhere with another capacity."""
    problem = Problem(read_experiment(logged_file(tmp_path, {}, LOGGERS[name], seed=6)))
    at = problem.neutral[0].copy()
    at[problem.slots.index("motor.shaft_heat_capacity")] = 1900.0
    problem.refine([at])
    resolved = problem.finest(0, at)
    monkeypatch.setattr(made_ready, "FINAL", Resolution(FINAL.cells, 0.5, 0.01, 1.0, 1e-4))
    exact = Problem(problem.experiment).finest(0, at)
    sigma = np.array([0.08 if "temperature" in v else 4e-7 for v in problem.variables])
    assert np.linalg.norm((resolved - exact) / sigma) < 0.07


@pytest.mark.parametrize(
    ("name", "effect", "logger"),
    [
        ("friction_level", {"friction": 1.25}, Logger(jitter=3.0, room=0.4)),
        ("joint_resistance", {"joint": 0.6}, Logger(jitter=2.4, room=0.4)),
        ("conductivity", {"conductivity": 140.0}, Logger(interval=8.0, jitter=3.0, room=0.4)),
    ],
)
def test_a_cause_is_named_whatever_the_logger(
    tmp_path: Path, name: str, effect: dict[str, float], logger: Logger
) -> None:
    found = assess(read_experiment(logged_file(tmp_path, effect, logger, seed=6)))
    assert found.word == "named"
    assert found.best.key == {name}
    assert found.artefact < 1.0


def test_values_that_are_found_are_those_where_the_grid_errs_no_more(tmp_path: Path) -> None:
    """The pad is reached at another time than in the model as it stands: a first search ends far away."""
    random = np.random.default_rng([241201, 50])
    effects = over_a_decade(KNOWN[int(random.integers(len(KNOWN)))], random)
    duty = drawn_duty(random, 5400.0)
    write_csv(hide(effects, duty, interval=15.0, seed=int(random.integers(2**31))), tmp_path / "run.csv")
    (tmp_path / "run.toml").write_text('system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n', "utf-8")
    found = assess(read_experiment(tmp_path / "run.toml"))
    problem, best = found.problem, found.best
    assert best.name == "friction_temperature_dependence"
    problem.refine(problem.values_by_run(best.freed, best.theta))
    again = found.fitter.fit(best.items, best.values)
    assert abs(again.theta[0] - best.theta[0]) < 0.05 * np.sqrt(best.covariance()[0, 0])


def test_where_nothing_is_searched_again_readings_are_as_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    logged_file(tmp_path, {"shaft_capacity": 1900.0}, LOGGERS["all at once"], seed=6)
    path = tmp_path / "run.toml"
    calibrated = '"motor.shaft_heat_capacity" = { min = 1000, max = 2500, start = 1200 }'
    text = f'system = "WarmupCell"\n[[run]]\ndata = "logged.csv"\n[calibrate]\n{calibrated}\n'
    path.write_text(text, "utf-8")
    found = assess(calibrating(read_experiment(path)))
    problem, (at,) = found.problem, found.problem.values_by_run(found.best.freed, found.best.theta)
    assert found.word == "adequate"
    ours = problem.finest(0, at)
    monkeypatch.setattr(made_ready, "FINAL", Resolution(FINAL.cells, 0.5, 0.01, 1.0, 1e-4))
    exact = Problem(problem.experiment).finest(0, at)
    sigma = np.array([0.08 if "temperature" in v else 4e-7 for v in problem.variables])
    assert np.linalg.norm((ours - exact) / sigma) < 0.07
