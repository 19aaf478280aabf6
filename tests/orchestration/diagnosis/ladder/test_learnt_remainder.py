"""A learnt remainder: where blocks ask for it, not where they do not, and the same in its component."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.remainder.component import COMPONENT
from warmlink.fmus.remainder.equations import TEMPERATURES
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.diagnose import read
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit, FitPoint
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.wandering import STILL
from warmlink.orchestration.diagnosis.ladder.baselines import filtered
from warmlink.orchestration.diagnosis.ladder.judged import REMAINDER, UNCORRECTED, JudgedModels
from warmlink.orchestration.diagnosis.ladder.prediction import Predicted, Scores
from warmlink.orchestration.diagnosis.ladder.remainder import Remainder, remainder
from warmlink.orchestration.diagnosis.ladder.wired import with_remainder
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.heat_paths import built_system
from warmlink.orchestration.scenarios.duties.duty import Segment

WORK = [
    *((1500, 2.6, 1.4), (600, 0, 0), (900, 1.1, 2.6), (1200, 3.3, 0.8), (420, 0, 0), (1500, 2.0, 2.2)),
    *((900, 0.9, 1.2), (1200, 2.9, 2.4), (1200, 1.6, 0.7), (900, 0, 0), (1500, 3.0, 1.5), (900, 1.0, 1.0)),
]


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    path = tmp_path_factory.mktemp("remainder") / "run.csv"
    write_csv(hide({}, [Segment(*each) for each in WORK], interval=30.0, seed=5, at_changes=True), path)
    return Problem(read([path]))


def lacking(problem: Problem) -> Array:
    """Readings of a model that lacks 3 um of growth that follow the square of the speed in 20 minutes."""
    run, data = problem.experiment.runs[0], problem.data[0]
    speed = run.inputs["motor.speed"][run.row_at(data.time - 1e-6)]
    missing = filtered(data.time, speed[:, None] ** 2, 1200.0)[:, 0]
    readings = problem.finest(0, problem.neutral[0]).copy()
    readings[:, problem.variables.index("link.elongation")] -= 3e-6 * missing / missing.max()
    return readings


def off(problem: Problem, readings: Array) -> float:
    """Held-out error of the growth, rms in m."""
    data, channel = problem.data[0], problem.variables.index("link.elongation")
    error = (data.readings - readings)[~data.fitted, channel]
    return float(np.sqrt(np.nanmean(error**2)))


def test_what_is_missing_is_learnt_where_blocks_ask_for_it(problem: Problem) -> None:
    readings = lacking(problem)
    learnt = remainder(problem, [readings])
    assert learnt is not None
    assert off(problem, learnt.readings[0]) < 0.4 * off(problem, readings)
    assert learnt.values["elongation_error"] < 0.5 * off(problem, readings)
    assert learnt.wires["speed"] == "motor.speed"


def test_no_remainder_is_learnt_of_what_no_output_of_the_system_is(problem: Problem, tmp_path: Path) -> None:
    """Such a one could not be wired, so that the extended system would lack what the page counts."""
    write_csv(hide({}, [Segment(*each) for each in WORK], interval=30.0, seed=5), tmp_path / "run.csv")
    table = pd.read_csv(tmp_path / "run.csv").rename(columns={"elongation [um]": "half [um]"})
    table["half [um]"] /= 2
    table.to_csv(tmp_path / "run.csv", index=False)
    channels = '[channels]\n"half [um]" = "0.5 * link.elongation"\n'
    experiment = 'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n' + channels
    (tmp_path / "e.toml").write_text(experiment, "utf-8")
    summed = Problem(read([tmp_path / "e.toml"]))
    channel = summed.variables.index("0.5 * link.elongation")
    readings = summed.finest(0, summed.neutral[0]).copy()
    of_output = lacking(problem)[:, problem.variables.index("link.elongation")]
    readings[:, channel] = np.interp(summed.data[0].time, problem.data[0].time, of_output) / 2
    learnt = remainder(summed, [readings])
    assert learnt is None or "0.5 * link.elongation" not in {*learnt.wires.values(), *learnt.weights}


def test_noise_asks_for_no_remainder(problem: Problem) -> None:
    sound = problem.finest(0, problem.neutral[0])
    learnt = remainder(problem, [sound])
    assert learnt is None or off(problem, learnt.readings[0]) < 1.1 * off(problem, sound)


def delivered(problem: Problem, readings: list[Array]) -> JudgedModels:
    """What is delivered beside a model that has these readings."""
    stands = Fit((), (), np.zeros(0), FitPoint(0.0, (), ()), ())
    model = Predicted(Carried(problem, stands), tuple(readings))
    noise = [NoiseModel(0.1 if problem.experiment.rig.unit(n) == "K" else 4e-7) for n in problem.variables]
    return JudgedModels(Scores(problem, noise, stands), STILL, {UNCORRECTED: model}, "unknown", False)


def test_the_end_of_one_run_asks_for_no_remainder_as_other_duty_cycles_do_not_speak(problem: Problem) -> None:
    assert delivered(problem, [lacking(problem)]).remainder is None


def test_a_channel_that_held_out_runs_do_not_ask_for_keeps_the_model(problem: Problem) -> None:
    """The growth lacks something in both runs, the shaft's error is in the fitted run alone."""
    run = problem.experiment.runs[0]
    runs = (replace(run, fit_until=1e6), replace(run, name="another", heldout=True))
    both = Problem(replace(problem.experiment, runs=runs))
    readings = [lacking(both), lacking(both)]
    shaft, growth = (both.variables.index(n) for n in ("motor.shaft_temperature", "link.elongation"))
    readings[0][:, shaft] -= 2.0 * np.sin(np.linspace(0.0, 3.0, len(readings[0])))
    whole = remainder(both, readings)
    assert whole is not None
    assert "motor.shaft_temperature" in whole.weights
    delivery = delivered(both, readings)
    assert delivery.name == REMAINDER
    assert delivery.remainder is not None
    assert list(delivery.remainder.weights) == ["link.elongation"]
    told = delivery.adopted.readings[1]
    assert np.array_equal(told[:, shaft], readings[1][:, shaft])
    assert np.array_equal(told[:, growth], whole.readings[1][:, growth])
    assert not any(key.startswith("temperature_weight") for key in delivery.remainder.values)


def test_held_out_rows_teach_nothing(problem: Problem) -> None:
    data = problem.data[0]
    spoiled = np.where(data.fitted[:, None], data.readings, data.readings + 1.0)
    other = Problem(problem.experiment)
    other.data = (replace(data, readings=spoiled),)
    one, same = remainder(problem, [lacking(problem)]), remainder(other, [lacking(problem)])
    assert one is not None
    assert same is not None
    assert one.values == same.values


def test_the_component_gives_what_was_learnt(problem: Problem) -> None:
    readings = lacking(problem)
    learnt = remainder(problem, [readings])
    assert learnt is not None
    run, data = problem.experiment.runs[0], problem.data[0]
    here = Instance(COMPONENT)
    here.set(dict(learnt.values))
    here.initialize()
    told, before = [], 0.0
    for i, now in enumerate(data.time.tolist()):
        row = run.row_at(np.array([now - 1e-6]))[0]
        fed = {}
        for taken, source in learnt.wires.items():
            known = source in problem.variables
            fed[taken] = readings[i, problem.variables.index(source)] if known else run.inputs[source][row]
        here.set({name: float(value) for name, value in fed.items()})
        if now > before:
            here.step(before, now - before)
        before = now
        told.append(here.get("corrected_elongation"))
    channel = problem.variables.index("link.elongation")
    assert np.abs(np.array(told) - learnt.readings[0][:, channel])[5:].max() < 0.3e-6


def outside_in(room: float, learnt: Remainder, idle: float) -> float:
    """How far outside the component says that it is, at rest in a room in K, with unused places at `idle`."""
    here = Instance(COMPONENT)
    here.set(dict(learnt.values))
    used = [name for name in learnt.wires if name.startswith("temperature[")]
    unused = {f"temperature[{i}]": idle for i in range(len(used) + 1, TEMPERATURES + 1)}
    here.set({**dict.fromkeys([*used, "ambient_temperature"], room), **unused})
    here.initialize()
    here.step(0.0, 300.0)
    return here.get("outside")


def test_what_nothing_feeds_is_never_outside(problem: Problem) -> None:
    """A place without a temperature stays at its start value, whatever the room is."""
    learnt = remainder(problem, [lacking(problem)])
    assert learnt is not None
    assert len(learnt.bank.places) < TEMPERATURES
    unfed = outside_in(298.15, learnt, 295.15)
    assert unfed == pytest.approx(outside_in(298.15, learnt, 298.15), abs=1e-9)
    assert outside_in(308.15, learnt, 295.15) > unfed


def test_a_spread_of_0_says_what_it_means() -> None:
    here = Instance(COMPONENT)
    here.initialize()
    spreads = [each for each in COMPONENT.outputs if each.name.endswith("_spread")]
    assert [here.get(name) for each in spreads for name in each.scalar_names] == [0.0] * (TEMPERATURES + 1)
    assert all(each.description.endswith("0: nothing was learnt") for each in spreads)


def test_it_stands_in_the_system_fed_by_the_model_and_by_its_duty(problem: Problem, tmp_path: Path) -> None:
    learnt = remainder(problem, [lacking(problem)])
    assert learnt is not None
    whole = with_remainder(built_system(problem.experiment.rig.machine), learnt, FmuStore("native"))
    fed = {link.target: link.source for link in whole.connections}
    assert fed["remainder.speed"] == "duty.speed"
    assert fed["remainder.elongation"] == "link.elongation"
    assert whole.components["remainder"].values["elongation_error"] == learnt.values["elongation_error"]
