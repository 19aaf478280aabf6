"""The gate on prediction: what the held-out rows contradict is not claimed."""

from pathlib import Path

import numpy as np
import pytest

from tests.documented import undescribed
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.verdict import Word
from warmlink.orchestration.diagnosis.ladder.prediction import HeldOut, verdict_after_holdout
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment


def off(times: float, in_noise: float) -> HeldOut:
    return HeldOut({"tip_temperature": times, "elongation": 0.9}, in_noise)


@pytest.mark.parametrize(
    ("word", "before", "after", "said"),
    [
        ("named", off(9, 8.0), off(1.1, 1.0), "named"),
        ("named", off(9, 8.0), off(2.5, 2.0), "empirical"),
        ("named", off(1.2, 1.1), off(1.4, 1.4), "unknown"),
        ("named", off(1.2, 1.8), off(1.1, 1.6), "empirical"),
        ("named", off(2.1, 4.6), off(0.8, 1.9), "named"),
        ("named", off(3.9, 9.9), off(1.0, 3.8), "empirical"),
        ("named", off(1.1, 1.05), off(1.1, 1.15), "named"),
        ("ambiguous", off(9, 8.0), off(2.5, 2.0), "ambiguous"),
        ("ambiguous", off(0.7, 2.1), off(0.5, 1.55), "empirical"),
        ("ambiguous", off(1.2, 1.1), off(1.4, 1.4), "unknown"),
        ("unknown", off(9, 8.0), off(4, 3.0), "empirical"),
        ("unknown", off(9, 8.0), off(7, 6.5), "unknown"),
        ("unknown", off(90, 80.0), off(30, 20.0), "unknown"),
        ("adequate", off(1.2, 1.1), off(1.2, 1.1), "adequate"),
        ("adequate", off(9, 8.0), off(9, 8.0), "unknown"),
    ],
)
def test_a_verdict_is_held_to_the_held_out_rows(
    word: Word, before: HeldOut, after: HeldOut, said: Word
) -> None:
    verdict, because = verdict_after_holdout(word, before, [after])
    assert verdict == said
    assert bool(because) == (word != said)


@pytest.mark.parametrize(
    ("before", "after", "verdict"),
    [(55.0, 9.9, "empirical"), (56.0, 12.5, "unknown"), (8.0, 3.9, "empirical"), (8.0, 4.1, "unknown")],
)
def test_what_the_last_digits_may_decide_is_called_close(before: float, after: float, verdict: Word) -> None:
    """A drone motor was `empirical` with steps in C that began on CasADi, and `unknown` with either alone."""
    word, because = verdict_after_holdout("unknown", off(9, before), [off(4, after)])
    assert word == verdict
    assert f"falls from {before:.2g} to {after:.2g} times the noise" in because
    assert "a close call" in because
    clear = verdict_after_holdout("unknown", off(9, before), [off(4, after / 2)])
    assert clear[0] == "empirical"
    assert "close" not in clear[1]


WORK = [
    *((1500, 2.6, 1.4), (600, 0, 0), (900, 1.1, 2.6), (1200, 3.3, 0.8), (420, 0, 0)),
    *((1500, 2.0, 2.2), (900, 0.9, 1.2), (1200, 2.9, 2.4), (1200, 1.6, 0.7)),
]


def test_what_the_fitted_rows_contradict_is_not_claimed(tmp_path: Path) -> None:
    """A thermometer of the room sees the shaft too, and a room that drifts and wanders was named."""
    columns = hide({}, [Segment(*each) for each in WORK], seed=26, at_changes=True)
    columns["ambient_temperature [degC]"] += 0.1 * (columns["shaft_temperature [degC]"] - 22.0)
    write_csv(columns, tmp_path / "run.csv")
    found = diagnose_experiment(read([tmp_path / "run.csv"]))
    assert found.verdict in ("empirical", "unknown")
    assert "times the noise" in json_content(found)["prediction"]["because"]
    assert not undescribed("diagnosis.json", json_content(found))


@pytest.mark.parametrize(("word", "said"), [("named", "empirical"), ("adequate", "unknown")])
def test_a_word_is_held_to_the_fitted_rows(word: Word, said: Word) -> None:
    assert verdict_after_holdout(word, None, [None], fitted=1.4)[0] == word
    assert verdict_after_holdout(word, None, [None], fitted=1.7)[0] == said


def test_without_held_out_rows_a_verdict_stays() -> None:
    assert verdict_after_holdout("named", None, [None]) == ("named", "")


def test_an_adequate_model_that_fails_on_the_held_out_rows_says_so(tmp_path: Path) -> None:
    columns = hide({}, interval=30.0, seed=1)
    late = columns["time [s]"] > 0.75 * columns["time [s]"][-1]
    columns["tip_temperature [degC]"][late] += 1.5
    spiky = np.flatnonzero(late)[::9]
    write_csv(columns, tmp_path / "run.csv")
    found = diagnose_experiment(read([tmp_path / "run.csv"]))
    assert found.verdict == "unknown"
    assert "adequate for the fitted run and does not predict the held-out one" in summary(found)
    content = json_content(found)
    assert "tip_temperature" in content["prediction"]["because"]
    assert not undescribed("diagnosis.json", content)
    columns["tip_temperature [degC]"][late] -= 1.5
    columns["tip_temperature [degC]"][spiky] += 9.0
    write_csv(columns, tmp_path / "run.csv")
    assert diagnose_experiment(read([tmp_path / "run.csv"])).verdict == "adequate"
