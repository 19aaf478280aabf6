"""The error that matters is said by the user, and a model below it is adequate for that."""

from dataclasses import replace

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.accuracy import with_accuracy
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.ladder.errors import good_enough, largest_errors
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    """A joint that clamps a little worse than it should."""
    path = tmp_path_factory.mktemp("accuracy") / "run.csv"
    write_csv(hide({"joint_resistance": 0.15}, interval=60.0, seed=3, at_changes=True), path)
    return read([path])


def test_a_model_below_what_matters_is_adequate_for_that(measured: Experiment) -> None:
    found = diagnose_experiment(measured)
    assert found.verdict in ("named", "ambiguous")
    largest = largest_errors(found.scores.by_channel(found.before))
    assert 0.1 < largest["tip_temperature"] < 3.0
    asked = replace(found, experiment=with_accuracy(measured, ["9 K", "elongation=60 um"]))
    assert asked.verdict == "adequate"
    assert "adequate for what you asked" in summary(asked)
    assert not asked.causes
    strict = replace(found, experiment=with_accuracy(measured, ["0.01 K", "elongation=60 um"]))
    assert strict.verdict == found.verdict


def test_one_figure_is_for_every_column_of_its_quantity(measured: Experiment) -> None:
    given = with_accuracy(measured, ["0.5 K"]).accuracy
    assert given["link.tip_temperature"] == 0.5
    assert "link.elongation" not in given
    both = with_accuracy(measured, ["0.5 K", "elongation=2 um", "tip_temperature=0.2 K"]).accuracy
    assert both["link.elongation"] == pytest.approx(2e-6)
    assert both["link.tip_temperature"] == 0.2


def test_it_is_said_which_columns_are_judged_by_their_noise(measured: Experiment) -> None:
    told = with_accuracy(measured, ["0.5 K"]).remarks[-1]
    assert told.startswith("which error matters is not said of elongation, so that noise judges it")
    assert "'elongation': '2 um'" in told
    assert with_accuracy(measured, ["0.5 K", "2 um"]).remarks == measured.remarks
    assert with_accuracy(measured, []).remarks == measured.remarks


@pytest.mark.parametrize(
    ("text", "said"),
    [("-1 K", "above 0"), ("3 V", "V"), ("T9=1 K", "is not measured"), ("elongation=", "elongation")],
)
def test_what_is_no_error_is_refused_in_a_sentence(measured: Experiment, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        with_accuracy(measured, [text])


def test_a_column_without_a_figure_is_judged_by_its_noise() -> None:
    errors, unknown = {"tip": 0.3, "elongation": 5e-6}, ("unknown", "")
    assert good_enough(errors, {"tip": (0.5, "degC")}, unknown) == unknown
    both = {"tip": (0.5, "degC"), "elongation": (6e-6, "um")}
    assert good_enough(errors, both, unknown)[0] == "adequate"
    assert "elongation is off most, by 5 um rms" in good_enough(errors, both, unknown)[1]
    assert good_enough({**errors, "tip": 0.6}, both, unknown) == unknown
