import numpy as np
import pytest

from benchmarks.strange_runs import LINES, measured
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue


@pytest.mark.parametrize("line", LINES)
def test_what_is_hidden_is_drawn_afresh_and_right_answers_are_causes(line: str) -> None:
    known = {cause.name for cause in catalogue()} | {"free_convection"}
    for seed in range(3):
        for right in LINES[line](np.random.default_rng(seed)).names:
            assert {name.partition(":")[0] for name in right.split("+")} <= known


def test_a_run_is_logged_as_a_machine_would() -> None:
    tables = [
        measured(LINES["link's logger late"](random), random, lasts=900.0)
        for random in map(np.random.default_rng, (1, 1, 2))
    ]
    for name in tables[0]:
        np.testing.assert_array_equal(tables[0][name], tables[1][name])
    assert tables[0]["time [s]"].size != tables[2]["time [s]"].size
    assert np.ptp(tables[0]["ambient_temperature [degC]"]) > 0
    assert all(np.isfinite(values).all() for name, values in tables[0].items() if "pad" not in name)


def test_rows_do_not_know_when_the_duty_cycle_changes() -> None:
    """There was one more at each change, as no logger has it."""
    for seed in range(4):
        random = np.random.default_rng(seed)
        spacing = np.diff(measured(LINES["nothing"](random), random, lasts=900.0)["time [s]"])
        assert spacing.min() > 0.45 * np.median(spacing)


def test_a_speed_wrong_one_way_is_right_the_other_way() -> None:
    speed = np.repeat([2.0, 0.0, 1.0, 3.0], 5)
    for seed in range(20):
        mislogged = LINES["speed wrong one way"](np.random.default_rng(seed)).mislogged
        assert mislogged is not None
        logged = {"speed": speed.copy()}
        mislogged(logged)
        ratio = logged["speed"][speed > 0] / speed[speed > 0]
        assert np.ptp(ratio) > 0.09
        assert ratio.min() == 1 or ratio.max() == 1
