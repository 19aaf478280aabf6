"""Before an instrument is blamed, the values that a person gave are asked whether they are wrong."""

from pathlib import Path
from typing import Any

import pytest

import warmlink as wl
from warmlink.orchestration.diagnosis import diagnose
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_experiment
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.known_values import known_value_causes

CONTACT = "(winding_temperature - base_temperature) / r"
"""Heat in W through a contact of the resistance r, which the owner of this cell gives."""


def experiment(folder: Path, given: str, effects: dict[str, float] | None = None) -> Experiment:
    """A run of a cell whose contact has 5 K/W, by an owner who gives another figure."""
    hidden = wl.hide(effects or {}, seed=1, terms=f"base: {CONTACT}; r = 5 K/W")[::2]
    hidden.to_csv(folder / "run.csv", index=False)
    file = folder / "experiment.toml"
    file.write_text(
        'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n'
        f'[term.mount]\nheat = "{CONTACT}"\ninto = "base"\nparameters = {{ r = "{given}" }}\n',
        encoding="utf-8",
    )
    return read_experiment(file)


@pytest.mark.slow
def test_a_wrong_contact_resistance_is_named_before_a_thermometer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An offset of the base's thermometer and two further causes made up for 2 % of a resistance."""
    before: list[Assessment] = []

    def recorded(*given: Any) -> Assessment:
        before.append(assess(*given))
        return before[-1]

    monkeypatch.setattr(diagnose, "assess", recorded)
    found = diagnose_experiment(experiment(tmp_path, "5.1 K/W"))
    assert any(name.startswith("sensor_") for name in before[0].best.key)
    assert found.verdict == "named"
    assert [item.title for item in found.causes] == ["known_value:mount.r"]
    (value,) = json_content(found)["causes"][0]["parameters"].values()
    assert value["low95"] <= 5.0 <= value["high95"]
    (told,) = json_content(found)["known_values"]
    assert "mount.r were" in told
    assert told in summary(found)


@pytest.mark.slow
def test_a_faulty_thermometer_is_blamed_where_the_resistance_is_right(tmp_path: Path) -> None:
    found = diagnose_experiment(experiment(tmp_path, "5 K/W", {"sensor_lag:tip_temperature": 60.0}))
    assert found.verdict == "named"
    assert [item.title for item in found.causes] == ["sensor_lag:tip_temperature"]


def test_values_that_nobody_gave_are_not_asked(tmp_path: Path) -> None:
    """A bare log of the shipped cell has none, and a value that is freed already is none either."""
    wl.hide(seed=1).to_csv(tmp_path / "bare.csv", index=False)
    assert known_value_causes(read_experiment(tmp_path / "bare.csv"), ()) == ()
    given = experiment(tmp_path, "5 K/W")
    assert [each.frees for each in known_value_causes(given, ())] == [("mount.r",)]
    assert known_value_causes(given, ("mount.r",)) == ()
