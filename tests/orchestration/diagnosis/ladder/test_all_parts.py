"""A plain calibration is judged on all parts of a log, each by the others, and not on its end alone."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from benchmarks.strange_machine import Demand, Machine
from tests.orchestration.diagnosis.ladder.test_ladder import ladder, made
from tests.shared_data import given
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.ladder import ladder_entries, ladder_lines
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import Experiment, together
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED, UNCORRECTED, chosen
from warmlink.orchestration.diagnosis.ladder.parts import PARTS, judged_by_parts
from warmlink.orchestration.diagnosis.ladder.plain import plainly_calibrated
from warmlink.orchestration.diagnosis.ladder.rungs import Ladder
from warmlink.orchestration.diagnosis.ladder.signals import growth_output
from warmlink.orchestration.threads import one_thread


def two(uncorrected: float, calibrated: float) -> Ladder:
    """The two models with errors of these sizes in every channel, the growth among them."""
    return replace(ladder(made(), uncorrected=uncorrected, calibrated=calibrated), growth=2)


def test_all_parts_of_a_log_outweigh_its_end() -> None:
    end = two(1.0, 2.0)
    assert chosen(end, "unknown", declared=False) == UNCORRECTED
    assert chosen(end, "unknown", declared=False, by_parts=two(3.0, 1.0)) == CALIBRATED
    assert chosen(two(2.0, 1.0), "unknown", declared=False, by_parts=two(1.0, 1.0)) == UNCORRECTED


def test_no_calibration_is_chosen_that_foretells_the_growth_worse_in_all_parts() -> None:
    parts = two(3.0, 1.0)
    first, other = parts.rungs
    table = other.readings[0].copy()
    table[:, 2] = made().readings[:, 2] + 4e-6
    spoiled = replace(parts, rungs=(first, replace(other, readings=(table,))))
    assert chosen(two(2.0, 1.0), "unknown", declared=False, by_parts=spoiled) == UNCORRECTED


@cache
def log() -> Experiment:
    """Of a machine of other structure: work, rest, and other work."""
    demands = [Demand(4000, 3.4, 2.5), Demand(2000), Demand(2000, 2.0, 3.0)]
    read_one = read([Machine(5).run(demands, 0).log().drop(columns="growth [um]").iloc[::60]])
    return replace(read_one, runs=(replace(read_one.runs[0], fit_until=np.inf),))


def by_parts(experiment: Experiment) -> Ladder:
    problem = Problem(experiment)
    fit = plainly_calibrated(problem)
    assert fit is not None
    stands = replace(fit, theta=np.array([freed.start for freed in fit.freed]))
    return judged_by_parts(problem, stands)


def test_each_part_is_foretold_by_fits_that_did_not_see_it() -> None:
    run = log().runs[0]
    last = run.time > run.time[0] + (PARTS - 1) / PARTS * (run.time[-1] - run.time[0])
    spoiled = replace(run, readings={n: np.where(last, r + 5e-3 * r, r) for n, r in run.readings.items()})
    both = [by_parts(each) for each in (log(), replace(log(), runs=(spoiled,)))]
    one, other = (each.named(CALIBRATED).readings[0] for each in both)
    there = both[0].runs[0].time > run.time[last][0] + 60
    warm = slice(0, -1)
    assert np.abs(one - other)[there, warm].max() < 0.05
    assert np.abs(one - other)[~there, warm].max() > 0.1
    assert np.isfinite(one).all()


def test_of_several_runs_each_is_foretold_by_the_others() -> None:
    run = log().runs[0]
    runs = [replace(log(), runs=(replace(run, name=name),)) for name in "abc"]
    warmer = {name: each + 2.0 * (name != "link.elongation") for name, each in run.readings.items()}
    other = replace(log(), runs=(replace(run, name="c", readings=warmer),))
    alike, apart = (
        by_parts(together([*runs[:2], last])).named(CALIBRATED).readings for last in (runs[2], other)
    )
    assert alike[0] == pytest.approx(alike[1], abs=0.05)
    assert np.abs(apart[2] - alike[2])[:, :-1].max() < 0.05
    assert np.abs(apart[0] - alike[0])[:, :-1].max() > 0.1


@pytest.mark.slow
def test_a_calibration_is_delivered_that_only_the_end_of_a_log_speaks_against() -> None:
    """Its end has other loads than the rest: nothing was delivered, and unseen runs stayed 8.6 um off."""
    logs = {
        name: pd.read_parquet(given("machine") / f"machine2_{name}.parquet").drop(columns="growth [um]")
        for name in ("training", "continuous", "random_shift")
    }
    experiments = {name: read([each.iloc[::10]]) for name, each in logs.items()}
    found = diagnose_experiment(experiments.pop("training"))
    with one_thread():
        assert found.delivered == CALIBRATED
        end, parts = (
            [each.rms(each.named(name))["elongation"] for name in (UNCORRECTED, CALIBRATED)]
            for each in (found.ladder, found.by_parts or found.ladder)
        )
        assert end[1] > end[0]
        assert parts[1] < 0.5 * parts[0]
        told = "\n".join(ladder_lines(found))
        assert "each part of the log by the others, the error of elongation falls from" in told
        assert "at the end of the log" in told
        said = ladder_entries(found)["by_parts"]
        assert said[CALIBRATED]["elongation"] == pytest.approx(1e6 * parts[1])
        assert "Where a thermometer is off from it by more than" in summary(found)
        unseen = Problem(
            together(
                [
                    replace(
                        each, runs=(replace(each.runs[0], name=name, heldout=True),), initial_measured=True
                    )
                    for name, each in experiments.items()
                ]
            )
        )
        before, after = (errors(unseen, fit) for fit in (found.before.fit, found.handed_on.fit))
    assert np.sqrt(np.mean(after**2)) < 0.5 * np.sqrt(np.mean(before**2))


def errors(problem: Problem, fit: Fit) -> Array:
    """Errors of a growth that counts from the start of each run, rms in m."""
    channel = problem.variables.index(growth_output(problem))
    found = []
    for run, z in enumerate(Carried(problem, fit).values):
        off = (problem.data[run].readings - problem.finest(run, z))[:, channel]
        off = off[np.isfinite(off)]
        found.append(np.sqrt(np.mean((off - off[:3].mean()) ** 2)))
    return np.array(found)
