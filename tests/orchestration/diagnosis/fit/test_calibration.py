"""Calibration arrives at the truth, and says what limits it: starts, bounds, a noise stated or not known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.orchestration.diagnosis.fit import two_lumps
from tests.orchestration.diagnosis.fit.two_lumps import (
    BETWEEN,
    BOUNDS,
    NOISE,
    OUT,
    SHAFT,
    WINDING,
    experiment,
    log,
)
from tests.shared_data import given
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import errors_in_noise
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import calibrating
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.report.diagnosis import extended_files, write_report

TRUTH = dict(zip(BOUNDS, (WINDING, SHAFT, BETWEEN, OUT), strict=True))


def calibrated(path: Path, noise: dict[str, float] | None = None) -> Diagnosis:
    return diagnose_experiment(replace(calibrating(read([path])), noise=noise or {}))


def assert_right(found: Diagnosis) -> None:
    numbers = {each.name: each for each in calibration(found)}
    for name, truth in TRUTH.items():
        assert numbers[name].low95 - 0.01 * truth < truth < numbers[name].high95 + 0.01 * truth
        assert numbers[name].value == pytest.approx(truth, rel=0.03)
    assert found.assessment.best.arrived


def test_a_far_start_ends_where_a_near_one_does(tmp_path: Path) -> None:
    far = {**BOUNDS, "motor.winding_heat_capacity": "5, 2000, 1900 J/K"}
    far["motor.shaft_heat_capacity"] = "20, 9000, 8500 J/K"
    found = calibrated(experiment(tmp_path, log(), far))
    assert_right(found)
    assert found.verdict == "adequate"


def test_rows_that_are_missing_and_a_start_that_is_not_the_given_one(tmp_path: Path) -> None:
    """Leaps of the current fall into long pauses, and the log begins when heating has begun."""
    table = log()
    kept = np.sort(np.random.default_rng(2).choice(np.arange(3, len(table)), 200, replace=False))
    found = calibrated(experiment(tmp_path, table.iloc[kept], BOUNDS))
    assert_right(found)
    assert "The first readings are not those of the start that is given" in summary(found)
    diagnosed = diagnose_experiment(read([experiment(tmp_path, table.iloc[kept], BOUNDS)]))
    assert_right(diagnosed)
    assert diagnosed.verdict == "adequate"


def test_a_start_far_from_the_given_one_is_found(tmp_path: Path) -> None:
    """The log begins after ten minutes of heat, one lump by 21 K warmer and the other by 14 K."""
    assert_right(calibrated(experiment(tmp_path, log().iloc[119:], BOUNDS)))


def test_bounds_that_are_met_are_said_on_the_page_and_in_words(tmp_path: Path) -> None:
    tight = {**BOUNDS, "motor.winding_conductance": "0.01, 1.5, 1 W/K"}
    found = calibrated(experiment(tmp_path, log(), tight))
    numbers = {each.name: each for each in calibration(found)}
    assert numbers["motor.winding_conductance"].at_bound
    assert not numbers["motor.housing_conductance"].at_bound
    assert "at its bound" in summary(found)
    write_report(found, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "At a bound of its calibration lies motor.winding_conductance" in page


@pytest.mark.parametrize(
    ("stated", "verdict", "said"), [(NOISE / 5, "unknown", "more than the noise"), (NOISE, "adequate", "")]
)
def test_a_stated_noise_rules_even_below_the_scatter(
    tmp_path: Path, stated: float, verdict: str, said: str
) -> None:
    path = experiment(tmp_path, log(step=10.0), BOUNDS)
    found = calibrated(path, {f"motor.{part}_temperature": stated for part in ("winding", "shaft")})
    assert found.verdict == verdict
    assert found.assessment.problem.reported_noise(0, found.assessment.noise) == pytest.approx(
        [stated, stated]
    )
    assert said in summary(found)
    assert ("is stated" in found.verdict_and_reason[1]) == (verdict == "unknown")


def test_no_model_is_within_a_noise_that_its_own_misfit_made(tmp_path: Path) -> None:
    """Rows so far apart that noise cannot be told by what is fast: ten kelvin were adequate."""
    wrong = '"motor.winding_heat_capacity" = "60 J/K"\n"motor.shaft_heat_capacity" = "4000 J/K"'
    more = f'{wrong}\n"motor.winding_conductance" = "2 W/K"'
    only = {"motor.housing_conductance": BOUNDS["motor.housing_conductance"]}
    found = calibrated(experiment(tmp_path, log(200_000.0, 20_000.0, 900.0), only, more))
    assert found.wrong["body"].rmse > 5.0
    assert found.verdict == "unknown"
    assert "scatters by" in found.verdict_and_reason[1]


def test_only_what_is_more_than_the_nominal_model_is_written(tmp_path: Path) -> None:
    found = calibrated(
        experiment(tmp_path, log(), {**BOUNDS, "motor.winding_conductance": "0.01, 1.5, 1 W/K"})
    )
    assert found.verdict == "unknown"
    assert extended_files(found, as_system=True) == ("extended.ssv", "extended.ssp")
    nominal = Diagnosis(replace(found.experiment, calibrated=()), found.assessment)
    assert nominal.verdict == "unknown"
    assert extended_files(nominal, as_system=True) == (None, None)


def test_the_log_is_that_of_two_lumps() -> None:
    table = two_lumps.log()
    assert table["wind [degC]"].iloc[0] == pytest.approx(22.0, abs=5 * NOISE)
    assert table["wind [degC]"].max() > table["body [degC]"].max() > 30.0


def assert_the_uncorrected_model_errs_alike(path: Path, verdict: set[str]) -> None:
    """Whether causes are looked for or not."""
    alone, diagnosed = calibrated(path), diagnose_experiment(read([path]))
    assert diagnosed.verdict in verdict
    assert diagnosed.assessment.null.theta == pytest.approx(alone.assessment.null.theta, rel=1e-6)
    first, second = (errors_in_noise(each, each.before, heldout=False) for each in (alone, diagnosed))
    assert first is not None
    assert second is not None
    assert second["rmse_before"] == pytest.approx(first["rmse_before"], rel=1e-4)
    for name, each in alone.wrong.items():
        there = diagnosed.wrong[name]
        assert (there.rmse, there.noise) == pytest.approx((each.rmse, each.noise), rel=1e-4)
    assert alone.remaining == alone.wrong


def test_the_uncorrected_model_errs_alike_where_a_cause_is_found(tmp_path: Path) -> None:
    wrong = '"motor.shaft_heat_capacity" = "300 J/K"'
    free = {name: text for name, text in BOUNDS.items() if name != "motor.shaft_heat_capacity"}
    path = experiment(tmp_path, log(), free, wrong)
    assert_the_uncorrected_model_errs_alike(path, {"named", "ambiguous"})


def test_the_uncorrected_model_errs_alike_where_no_cause_is_found() -> None:
    assert_the_uncorrected_model_errs_alike(given("logs_that_fail/shift.toml"), {"unknown"})


def test_a_time_limit_ends_a_calibration_with_the_best_numbers_so_far(tmp_path: Path) -> None:
    """It went on from four starts, however long that took."""
    far = {**BOUNDS, "motor.winding_heat_capacity": "5, 2000, 1900 J/K"}
    path, numbers = experiment(tmp_path, log(), far), {}
    for limit in (1e-6, 1e6):
        found = diagnose_experiment(calibrating(read([path]), limit))
        ended = "The time limit of 1e-06 s ended the calibration" in summary(found)
        assert ended == (limit < 1)
        numbers[limit] = {each.name: each.value for each in calibration(found)}
        assert set(numbers[limit]) == set(TRUTH)
    assert numbers[1e-6] != pytest.approx(numbers[1e6], rel=0.05)
