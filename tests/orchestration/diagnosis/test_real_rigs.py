"""Strangers' rigs, where the machine has their measurements: what is delivered is no worse than before."""

from pathlib import Path

import pytest

from tests.real_rigs import RIGS
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.ladder import ladder_lines
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.ladder.rungs import AS_GOOD
from warmlink.orchestration.threads import one_thread


def diagnosed(name: str, folder: Path) -> Diagnosis:
    """Diagnosis of a rig."""
    found = diagnose_experiment(read([RIGS[name].write(folder)]))
    with one_thread():
        assert found.ladder.is_judged
    return found


def check(found: Diagnosis) -> dict[str, float]:
    """Held-out errors in SI of what is delivered; fails where it is worse than the uncorrected model."""
    ladder = found.ladder
    rung = next(each for each in ladder.rungs if each.name == found.delivered)
    assert ladder.score(rung) <= ladder.score(ladder.rungs[0])
    errors = ladder.rms(rung)
    for plain in (each for each in ladder.rungs if not each.is_model and each.question == "simulation"):
        if any(error > AS_GOOD * ladder.rms(plain).get(name, 1e9) for name, error in errors.items()):
            assert any(" better: " in line for line in ladder_lines(found))
    return errors


@pytest.mark.platform
def test_a_drone_motor_is_foretold_better_than_by_plain_fits(tmp_path: Path) -> None:
    errors = check(diagnosed("drone motor, 10D to 10C", tmp_path))
    assert errors["winding"] <= AS_GOOD * 6.3
    assert errors["stator"] <= AS_GOOD * 1.8


@pytest.mark.platform
def test_a_pouch_cell_is_foretold_better_than_by_plain_fits(tmp_path: Path) -> None:
    errors = check(diagnosed("pouch cell", tmp_path))
    assert errors["spot"] <= AS_GOOD * 0.12
    assert errors["face"] <= AS_GOOD * 0.23


@pytest.mark.platform
def test_causes_that_foretell_worse_than_the_model_as_it_stands_are_not_claimed(tmp_path: Path) -> None:
    found = diagnosed("drone motor, 13 to 14", tmp_path)
    check(found)
    assert found.verdict == "unknown"
    assert not found.delivers
    assert "Nothing is delivered" in "\n".join(ladder_lines(found))


@pytest.mark.platform
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_what_is_delivered_of_a_printers_frame_is_the_plain_fit_that_foretells_it_best(
    tmp_path: Path,
) -> None:
    found = diagnosed("printer's frame", tmp_path)
    errors, ladder = check(found), found.ladder
    assert errors["growth"] <= AS_GOOD * 10.6e-6
    for plain in ladder.plain("simulation"):
        assert all(error <= AS_GOOD * ladder.rms(plain)[name] for name, error in errors.items())
    assert found.delivery.predictor is not None
    assert found.delivery.predictor.outputs == {"link.elongation": "growth"}


@pytest.mark.platform
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_a_copper_bar_is_foretold_better_than_by_plain_fits(tmp_path: Path) -> None:
    errors = check(diagnosed("copper bar", tmp_path))
    assert len(errors) == 6
    assert max(errors.values()) <= AS_GOOD * 0.44


@pytest.mark.platform
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_a_house_is_foretold_better_than_by_the_model_as_it_stands(tmp_path: Path) -> None:
    check(diagnosed("house", tmp_path))
