"""The error that matters is said by the user, and a model below it is adequate for that."""

from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.errors import good_enough, largest_errors
from warmlink.orchestration.diagnosis.data.accuracy import with_accuracy
from warmlink.orchestration.diagnosis.data.experiment import Experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.products.diagnose import diagnose


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A joint that clamps a little worse than it should."""
    path = tmp_path_factory.mktemp("accuracy") / "run.csv"
    write_csv(hide({"joint_resistance": 0.15}, interval=60.0, seed=3, at_changes=True), path)
    return path


@pytest.fixture(scope="module")
def measured(run: Path) -> Experiment:
    return read([run])


def test_a_model_below_what_matters_is_adequate_for_that(run: Path, measured: Experiment) -> None:
    found = diagnose_experiment(measured)
    assert found.verdict in ("named", "ambiguous")
    largest = largest_errors(found.scores.by_channel(found.before))
    assert 0.1 < largest["tip_temperature"] < 3.0
    asked = diagnose(
        run, accuracy={**dict.fromkeys(set(largest) - {"elongation"}, "9 K"), "elongation": "60 um"}
    )
    assert asked.verdict == "adequate"
    assert "adequate for what you asked" in asked.summary()
    assert " rms, and " in asked.summary()
    assert not asked.causes
    strict = diagnose(run, accuracy="0.01 K")
    assert strict.verdict == found.verdict


def test_one_figure_is_for_every_column_of_its_quantity(measured: Experiment) -> None:
    given = with_accuracy(measured, ["0.5 K"]).accuracy
    assert given["link.tip_temperature"] == 0.5
    assert "link.elongation" not in given
    both = with_accuracy(measured, ["0.5 K", "elongation=2 um", "tip_temperature=0.2 K"]).accuracy
    assert both["link.elongation"] == pytest.approx(2e-6)
    assert both["link.tip_temperature"] == 0.2


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
