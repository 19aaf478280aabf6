"""What is foreseen for other duty cycles holds in the other solver, and says so where it does not."""

import re
from dataclasses import replace

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.answer.claims import DUTIES, claims
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.profile import profiles_of
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hidden import Truth, simulate
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties import duty_files


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """A joint that clamps badly."""
    path = tmp_path_factory.mktemp("loose") / "run.csv"
    write_csv(hide({"joint_resistance": 0.5}, interval=60.0, seed=12, at_changes=True), path)
    return diagnose_experiment(read([path]))


def most_wrong(loose: Diagnosis) -> str:
    """The channel that is off most on fitted rows, as a multiple of its noise."""
    return max(loose.wrong, key=lambda each: loose.wrong[each].rmse / loose.wrong[each].noise)


def test_the_growth_in_other_duty_cycles_lies_in_its_band(loose: Diagnosis) -> None:
    assert [each.duty for each in loose.claims] == list(DUTIES)
    for claim in loose.claims[:-1]:  # the other solver takes long over a shift
        duty = duty_files.load(claim.duty)
        truth = simulate(Truth(joint=0.5), list(duty.unrolled()), claim.time).elongation
        assert np.all(np.abs(truth - claim.elongation) <= claim.band + 0.05e-6), claim.duty
        assert np.abs(truth - claim.elongation).max() < 0.3 * np.abs(truth - claim.before).max()
        assert claim.holds
    told = summary(loose)
    assert "other duty cycles it foresees the growth" in told
    assert re.search(
        r"elongation: [\d.]+ µm rms against [\d.]+ µm of noise, worst (while \w+|after a change)", told
    )
    on_fitted = (
        rf"after on fitted rows \({most_wrong(loose)} from [\d.]+ to [\d.]+ \S+ rms\); [\d.]+ before and"
    )
    assert re.search(r"noise: [\d.]+ before and [\d.]+ " + on_fitted, told)
    assert [each["duty"] for each in json_content(loose)["claims"]] == list(DUTIES)


def test_what_is_left_unexplained_widens_the_band(loose: Diagnosis) -> None:
    left = {"elongation": replace(loose.remaining["elongation"], rmse=1.6e-6)}
    doubtful = claims(loose.experiment, loose.assessment, (loose.after,), left)
    holds = {each.duty: each.holds for each in doubtful}
    assert not holds["heavy_payload"]
    assert holds["light_payload"]


def test_chi_square_rises_by_one_at_one_standard_deviation(loose: Diagnosis) -> None:
    (profile,) = profiles_of(loose.assessment)
    assert profile.variable == "motor.joint_resistance"
    even = (profile.rise + profile.rise[::-1]) / 2  # a resistance acts the less the larger it is
    assert even == pytest.approx([9, 4, 1, 0, 1, 4, 9], abs=0.3)
