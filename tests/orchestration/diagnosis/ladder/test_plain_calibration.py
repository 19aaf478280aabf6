"""A plain calibration on a log of a machine of other structure: what the log does not tell stays as usual."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

from benchmarks.strange_machine import Demand, Machine
from tests.shared_data import given
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import Experiment, together
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.fitted import Carried
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.verdict import fitted_part
from warmlink.orchestration.diagnosis.ladder.judged import CALIBRATED, CAUSES, NEAREST
from warmlink.orchestration.diagnosis.ladder.plain import plainly_calibrated

FITTED = [Demand(9000, 3.4, 2.5), Demand(3600)]
"""One speed and torque, and rest: copper loss and friction are heat alike."""

UNSEEN = {"as fitted": [Demand(9000, 3.4, 2.5)], "slow and heavy": [Demand(9000, 1.0, 3.7)]}


@cache
def calibrated() -> tuple[Fit, dict[str, tuple[Array, Array, Array]]]:
    """Calibration on one log, and by unseen run the errors without it and with it, and what it foresees.

    That is how far readings may be off, uncertain as the numbers are; all by channel, root mean square.
    """
    machine, runs = Machine(1), []
    for seed, (name, demands) in enumerate({"fitted": FITTED, **UNSEEN}.items()):
        log = machine.run(demands, seed).log().drop(columns="growth [um]").iloc[::60]
        read_one = read([log])
        run = replace(read_one.runs[0], name=name, heldout=name in UNSEEN, fit_until=1e6)
        runs.append(replace(read_one, runs=(run,)))
    whole = Problem(together(runs))
    problem = Problem(fitted_part(whole.experiment))
    fit = plainly_calibrated(problem)
    assert fit is not None
    errors = {}
    for i, name in enumerate(UNSEEN, 1):
        model = Carried(whole, fit)
        before, after = (
            np.sqrt(np.nanmean((whole.data[i].readings - whole.predict(i, z)[0]) ** 2, axis=0))
            for z in (whole.neutral[i], model.values[i])
        )
        errors[name] = before, after, np.sqrt(np.mean(model.variance(i), axis=0))
    return fit, errors


def test_what_is_as_in_the_log_is_foretold_far_better() -> None:
    before, after, _ = calibrated()[1]["as fitted"]
    assert np.mean(after / before) < 0.5
    assert after[-1] < 0.6 * before[-1]


def test_what_one_speed_and_torque_do_not_tell_apart_stays_as_usual() -> None:
    fit, errors = calibrated()
    values = {freed.variable: value / freed.start for freed, value in fit.values.items() if freed.start > 0}
    for name in ("motor.winding_resistance", "motor.winding_heat_capacity", "motor.shaft_heat_capacity"):
        assert values[name] == pytest.approx(1.0, abs=0.3)
    before, after, _ = errors["slow and heavy"]
    assert after[-1] < 2.5 * before[-1]


def test_a_load_that_a_log_tells_nothing_of_is_known_to_be_in_doubt() -> None:
    """By the noise of thermometers alone growth under other loads was known to a quarter of its error."""
    errors = calibrated()[1]
    _, after, foreseen = errors["slow and heavy"]
    assert after[-1] < 2 * foreseen[-1]
    assert foreseen[-1] > 4 * errors["as fitted"][2][-1]


@pytest.mark.slow
def test_causes_that_do_not_explain_a_log_are_not_delivered_for_its_end() -> None:
    """Three of them took the growth at a log's end from 5.5 to 1.7 um, and unseen runs from 8.9 to 12.6."""
    log = pd.read_parquet(given("machine") / "machine1_training.parquet").drop(columns="growth [um]")
    found = diagnose_experiment(read([log.iloc[::10]]))
    assert found.assessment.word == "unknown"
    assert found.verdict == "empirical"
    assert NEAREST in found.models
    assert found.delivered == CALIBRATED
    lines = summary(found).splitlines()
    assert sum(line.startswith("Not established: ") for line in lines) == 1
    assert any(line.startswith("Do not use it for other duty cycles") for line in lines)


@pytest.mark.parametrize(("fitted", "rung"), [("unknown", NEAREST), ("named", CAUSES)])
def test_causes_count_as_such_where_they_explain_the_fitted_rows(fitted: str, rung: str) -> None:
    """Held-out rows alone had made causes of those that explain nothing."""
    assessment = SimpleNamespace(word=fitted, best=SimpleNamespace(items=("friction",)))
    found = Diagnosis(cast(Any, SimpleNamespace(calibrated=())), cast(Any, assessment))
    kept = {"_gated": ("empirical", ""), "before": "before", "after": "after", "_plainly_calibrated": None}
    found.__dict__.update(kept)
    assert list(found.models) == ["uncorrected", rung]


def test_a_chosen_calibration_is_fitted_to_the_end_of_a_log_too_but_to_no_run_that_a_person_held_out() -> (
    None
):
    log = Machine(1).run(FITTED, 0).log().drop(columns="growth [um]").iloc[::60]
    ends_unfitted = read([log])
    run = replace(ends_unfitted.runs[0], fit_until=np.inf)
    all_fitted = replace(ends_unfitted, runs=(run,))
    other = replace(run, name="other", heldout=True, readings={n: 1.1 * r for n, r in run.readings.items()})

    def refitted(experiment: Experiment) -> Array:
        found = Diagnosis(experiment, cast(Any, None))
        scores = SimpleNamespace(predict=lambda fit: fit)
        found.__dict__.update(_plainly_calibrated="chosen", scores=scores)
        return cast(Any, found.refitted).theta

    to_all = plainly_calibrated(Problem(all_fitted))
    assert to_all is not None
    assert refitted(ends_unfitted) == pytest.approx(to_all.theta)
    assert refitted(replace(all_fitted, runs=(run, other))) == pytest.approx(to_all.theta)


@pytest.mark.parametrize(
    ("model", "remainder", "handed_on"),
    [(CALIBRATED, None, "again"), (CALIBRATED, "learnt", "chosen"), (CAUSES, None, "chosen")],
)
def test_a_calibration_alone_is_handed_on_as_it_was_refitted(
    model: str, remainder: str | None, handed_on: str
) -> None:
    found = Diagnosis(cast(Any, None), cast(Any, None))
    delivery = SimpleNamespace(model=model, remainder=remainder, adopted="chosen")
    found.__dict__.update(delivery=delivery, refitted="again")
    assert cast(Any, found.handed_on) == handed_on
