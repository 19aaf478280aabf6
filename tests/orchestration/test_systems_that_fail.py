"""Small systems of other people's making, on which the command once gave wrong numbers or none."""

from __future__ import annotations

from typing import Any

import pytest

from tests.orchestration.simulated import simulate
from tests.shared_data import given

pytestmark = pytest.mark.usefixtures("in_a_fresh_folder")


def outcome(
    name: str, *options: str, capsys: pytest.CaptureFixture[str], expected: int = 0
) -> tuple[dict[str, Any], str]:
    """Last value of each output, and what was said."""
    path = given(f"systems_that_fail/{name}.ssp")
    answer, err = simulate(path, *options, "--out", "o", capsys=capsys, expected=expected)
    return {output: figures["last"] for output, figures in answer["outputs"].items()}, err


@pytest.mark.parametrize(
    ("name", "options", "values"),
    [
        ("setup_after_start_values/s", (), {"c.y": 5.0}),
        ("noSetFMUState_flag/s", (), {"c.flag": 1.0, "c.y": 1.0}),
        ("INTOCPS17_once_per_process/once", (), {"a.y": 1.0, "b.y": 5.0}),
        ("INTOCPS17_once_per_process/silent", (), {"a.y": 1.0, "b.y": 5.0}),
        ("FMPy118_stop_time/s", (), {"c.stop": 1.0, "c.tol": 1e-6}),
        ("FMPy118_stop_time/s", ("--fmu-tolerance", "1e-3"), {"c.stop": 1.0, "c.tol": 1e-3}),
    ],
)
def test_the_numbers_are_right(
    name: str, options: tuple[str, ...], values: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    found, _ = outcome(name, "--step", "0.1 s", *options, capsys=capsys)
    assert found == pytest.approx(values)


def test_the_step_of_an_fmu_is_taken_and_a_budget_that_it_cannot_make_costs_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found, err = outcome("fmi575_fixed_step_last/s", capsys=capsys)
    assert found == {"c.n": 3.0}
    assert "the coupling error is not bounded, for the run at half the step failed: c: error" in err
    assert "the run ends at 0.9 s: no step of 0.3 s ends at 1 s" in err


def test_another_step_is_refused_by_the_fmu_with_advice_that_works(
    capsys: pytest.CaptureFixture[str],
) -> None:
    _, err = outcome("fmi575_fixed_step_last/s", "--step", "0.1 s", capsys=capsys, expected=1)
    assert 'give --step "0.3 s" --stop "0.9 s"' in err
    found, _ = outcome("fmi575_fixed_step_last/s", "--step", "0.3 s", "--stop", "0.9 s", capsys=capsys)
    assert found == {"c.n": 3.0}


def test_a_step_that_cannot_be_halved_is_no_failure(capsys: pytest.CaptureFixture[str]) -> None:
    found, err = outcome("FMPy887_60Hz/s", "--step", repr(1 / 60), capsys=capsys)
    assert found["c.n"] == 6000.0
    assert "the coupling error is not bounded" in err


def test_one_of_several_descriptions_is_chosen(capsys: pytest.CaptureFixture[str]) -> None:
    found, err = outcome("OMS1550_variants/s", "--step", "0.1 s", capsys=capsys)
    assert found == {"g.y": 1.0}
    assert "beside it VarB; --variant VarB runs VarB instead" in err
    found, err = outcome("OMS1550_variants/s", "--step", "0.1 s", "--variant", "VarB", capsys=capsys)
    assert found == {"g.y": 2.0}
    assert "VarB instead" not in err
    path = given("systems_that_fail/OMS1550_variants/s.ssp")
    _, err = simulate(path, "--variant", "VarC", capsys=capsys, expected=2)
    assert "no variant of the system in s.ssp; did you mean VarB?" in err
