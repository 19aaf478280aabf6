"""Plain fits as a component say what they said on the ladder, and stand in the system beside the model."""

from dataclasses import replace

import numpy as np
import pytest

from tests.orchestration.diagnosis.ladder.test_ladder import made
from warmlink.fmus.component.instance import Instance
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.baselines import Baseline, baselines
from warmlink.orchestration.diagnosis.ladder.predictor import Predictor, predictor_of
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder, Rung
from warmlink.orchestration.diagnosis.ladder.signals import Signals, signals_of
from warmlink.orchestration.diagnosis.ladder.wired import with_predictor
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.machine.heat_paths import built_system
from warmlink.orchestration.scenarios.duties.duty import Segment

WORK = [(1500, 2.6, 1.4), (600, 0, 0), (900, 1.1, 2.6), (1200, 3.3, 0.8), (420, 0, 0), (1500, 2.0, 2.2)]


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    path = tmp_path_factory.mktemp("plain") / "run.csv"
    write_csv(hide({}, [Segment(*each) for each in WORK], interval=30.0, seed=5, at_changes=True), path)
    return Problem(read([path]))


@pytest.fixture(scope="module")
def fits(problem: Problem) -> tuple[tuple[Signals, ...], dict[str, Baseline]]:
    runs = signals_of(problem)
    found = baselines(runs, [problem.experiment.rig.unit(each) == "K" for each in problem.variables])
    return runs, {each.name: each for each in found}


def made_of(problem: Problem, runs: tuple[Signals, ...], fit: Baseline, name: str = "Predictor") -> Predictor:
    return predictor_of(problem, runs, {c: (each, 0.1) for c, each in fit.linear.items()}, name, "plain fits")


@pytest.mark.parametrize("name", ["first-order lag", "ARX"])
def test_the_component_says_what_the_fit_said(
    problem: Problem, fits: tuple[tuple[Signals, ...], dict[str, Baseline]], name: str
) -> None:
    runs, by_name = fits
    predictor, run = made_of(problem, runs, by_name[name]), problem.experiment.runs[0]
    here = Instance(predictor.component)
    shown = here.component.parameters[0].name
    here.set({shown: 5.0})
    told, before, time = [], 0.0, runs[0].time
    for i, now in enumerate(time.tolist()):
        row = run.row_at(np.array([now - 1e-6]))[0]
        here.set({taken: float(run.inputs[source][row]) for taken, source in predictor.inputs.items()})
        if i == 0:
            here.initialize()
        if now > before:
            here.step(before, now - before)
        before = now
        told.append([here.get(predictor.outputs[each]) for each in problem.variables])
    error = np.array(told) - by_name[name].readings[0]
    size = np.ptp(by_name[name].readings[0], axis=0)
    assert (np.abs(error).max(axis=0) < 0.02 * size).all()


def test_it_stands_in_the_system_fed_by_its_duty(
    problem: Problem, fits: tuple[tuple[Signals, ...], dict[str, Baseline]]
) -> None:
    runs, by_name = fits
    predictor = made_of(problem, runs, by_name["first-order lag"])
    whole = with_predictor(built_system(problem.experiment.rig.machine), predictor)
    fed = {link.target: link.source for link in whole.connections}
    assert fed["predictor.speed"] == "duty.speed"


def rungs(**sizes: float) -> tuple[Signals, list[Rung]]:
    run, found = made(), []
    for k, (name, size) in enumerate(sizes.items()):
        noise = np.random.default_rng(k).normal(size=run.readings.shape) * size * [1, 1, 1e-6]
        found.append(Rung(name, "simulation", (run.readings + noise,), k))
    return run, found


def test_a_plain_fit_that_is_clearly_better_in_a_channel_is_found_and_a_little_better_one_is_not() -> None:
    run, (model, better, alike) = rungs(model=1.0, better=0.2, alike=0.99)
    ladder = Ladder((run,), ("shaft", "tip", "growth"), (model, better, alike))
    assert ladder.best_in(2, [better, alike], model) is better
    assert ladder.best_in(2, [alike], model) is None
    assert ladder.best_in(2, [], model) is None
    careless = replace(ladder, accuracy={2: 5e-6})
    assert careless.best_in(2, [better], model) is None
