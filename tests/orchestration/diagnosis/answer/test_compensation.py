"""What an observer would have left: the same whatever the columns of the log are called."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration.diagnosis.answer.compensated import Compensated, observer
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.diagnosis.fit.fitting import Fit
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv

EXPERIMENT = """
system = "WarmupCell"
[[run]]
data = "renamed.csv"

[channels]
"T_base" = "link.base_temperature"
"T_tip" = "link.tip_temperature"
"""


def compensated(path: Path) -> Compensated:
    nothing: Any = None
    uncorrected = Fit((), (), np.empty(0), nothing, ())
    found = observer(Problem(read_experiment(path)), uncorrected, uncorrected)
    assert found is not None
    return found


def test_an_observer_goes_by_thermometers_whatever_their_columns_are_called(tmp_path: Path) -> None:
    usual, renamed = tmp_path / "run.csv", tmp_path / "renamed.csv"
    write_csv(hide({}), usual)
    renamed.write_text(
        usual.read_text().replace("base_temperature", "T_base").replace("tip_temperature", "T_tip")
    )
    (tmp_path / "experiment.toml").write_text(EXPERIMENT)
    expected = compensated(usual)
    assert expected.largest < 5e-6
    assert compensated(tmp_path / "experiment.toml").largest == pytest.approx(expected.largest, rel=1e-9)
