"""A logger's rows do not know when a demand changes, and nothing is made of that."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.answer.entries import errors_in_noise
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.data.measured import Run
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment
from warmlink.orchestration.diagnosis.fit.verdict import assess
from warmlink.orchestration.diagnosis.model.simulation import input_table
from warmlink.orchestration.diagnosis.model.steps import leaps
from warmlink.orchestration.diagnosis.practice.hide import INFORMATIVE, REAL, WHITE, Noise, hide, write_csv
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.scenarios.duties.duty import Segment

UNEVEN = [
    *((617, 2.6, 1.4), (903, 1.1, 2.6), (604, 0, 0), (1207, 3.3, 0.8), (425, 0, 0), (911, 2.0, 2.2)),
    *((906, 0.9, 1.2), (609, 2.9, 2.4), (1213, 1.6, 0.7)),
]
"""Work in which no change comes at a round time."""


@pytest.mark.parametrize(("interval", "seed"), [(7.0, 1), (13.0, 2), (30.0, 3)])
def test_rows_beside_the_changes_are_no_fault(tmp_path: Path, interval: float, seed: int) -> None:
    """Late clocks, more iron loss and the like were named: a leap was taken to come at its row exactly."""
    columns = hide({}, [Segment(*each) for each in UNEVEN], interval=interval, seed=seed)
    write_csv(columns, tmp_path / "run.csv")
    assert assess(read_experiment(tmp_path / "run.csv")).word == "adequate"


def test_errors_are_told_in_units_of_all_of_the_noise(tmp_path: Path) -> None:
    """A run with nothing wrong was off by 2.1 times the noise, and worst after a change of torque."""
    write_csv(hide({}, INFORMATIVE, interval=7.0, seed=14), tmp_path / "run.csv")
    found = diagnose_experiment(read_experiment(tmp_path / "run.csv"))
    assert found.verdict == "adequate"
    for heldout in (False, True):
        errors = errors_in_noise(found, found.before, heldout)
        assert errors is not None
        assert 0.9 < errors["rmse_before"] < 1.1
    assert not any(each.when for each in found.wrong.values())


def test_a_pad_between_two_rows_is_no_fault(tmp_path: Path) -> None:
    write_csv(hide({}, INFORMATIVE, interval=13.0, seed=4), tmp_path / "run.csv")
    assert assess(read_experiment(tmp_path / "run.csv")).word == "adequate"


def test_rows_at_the_changes_are_no_fault_either(tmp_path: Path) -> None:
    columns = hide({}, [Segment(*each) for each in UNEVEN], seed=5, at_changes=True)
    changes = np.cumsum([each[0] for each in UNEVEN])[:-1]
    assert np.isin(changes, columns["time [s]"]).all()
    write_csv(columns, tmp_path / "run.csv")
    assert assess(read_experiment(tmp_path / "run.csv")).word == "adequate"


def test_a_room_warms_on_in_a_gap_of_its_log(tmp_path: Path) -> None:
    """It was held for ten minutes and then leapt, which passed for a clock that drifts."""
    room = [
        Segment(30.0, *((2.6, 1.4), (0.0, 0.0), (1.1, 2.6))[i // 80], 295.15 + i / 80) for i in range(240)
    ]
    columns = hide({}, room, interval=10.0, seed=6)
    seen = (columns["time [s]"] < 2500) | (columns["time [s]"] > 3300)
    write_csv({name: values[seen] for name, values in columns.items()}, tmp_path / "run.csv")
    assert assess(read_experiment(tmp_path / "run.csv")).word == "adequate"


def test_a_leap_at_the_end_of_a_gap_of_the_log_is_no_fault(tmp_path: Path) -> None:
    """A leap by some s was taken for a share of one by minutes, and the rest passed for a late clock."""
    columns = hide({}, seed=4)
    seen = (columns["time [s]"] < 1720) | (columns["time [s]"] > 1980)
    write_csv({name: values[seen] for name, values in columns.items()}, tmp_path / "run.csv")
    assert assess(read_experiment(tmp_path / "run.csv")).word == "adequate"


def test_a_pad_that_is_set_anew_leaps() -> None:
    """A pad that was off for a while was at 0 K then, and any change of a hot one small beside that."""
    pad = np.array([np.nan, 314.0, 340.0, 340.5, 340.0, np.nan])
    run = Run("run", np.arange(6.0), {"motor.pad_temperature": pad}, {})
    assert leaps(input_table(rig("WarmupCell", 20), run, {})).tolist() == [1, 2, 5]


@pytest.mark.parametrize(
    ("effects", "noise", "seed"),
    [
        ({"housing_heat_loss": 1.135}, WHITE, 1076715990),
        ({"joint_resistance": 0.2135, "hub_heat_capacity": 54.7}, WHITE, 1556346340),
        ({"clock_offset": -31.5}, WHITE, 322284123),
        ({"clock_offset": -29.0, "ambient_drift": -5e-4}, REAL, 847848),
        ({"clock_offset": -30.1, "friction_level": 0.875}, WHITE, 36067476),
        ({"clock_offset": -90.0}, WHITE, 7),
    ],
)
def test_a_clock_is_named_only_where_it_is_off(
    tmp_path: Path, effects: Mapping[str, float], noise: Noise, seed: int
) -> None:
    """It was named beside the right causes, and not found off by rows, or where it showed held-out work."""
    write_csv(hide(effects, noise=noise, seed=seed), tmp_path / "run.csv")
    found = assess(read_experiment(tmp_path / "run.csv"))
    assert (found.word, found.best.key) == ("named", set(effects))
