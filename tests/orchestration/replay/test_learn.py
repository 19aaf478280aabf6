"""`warmlink design --data` and `wl.design(data=...)`: what is learnt, what is written, what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import warmlink as wl
from benchmarks.strange_machine import Machine, training
from tests.command import exit_code
from tests.shared_data import given
from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controllers
from warmlink.orchestration.replay.compare import replay_figures, replayed
from warmlink.orchestration.replay.learn import LearntLaw, learnt_law
from warmlink.orchestration.replay.logs import MeasuredLog, read_logs
from warmlink.orchestration.system.ssp.parameter_values import read_ssv


@cache
def log(seconds: int = 18000) -> pd.DataFrame:
    return Machine(1).run(training(), 1).log().iloc[:seconds].reset_index(drop=True)


@cache
def learnt() -> LearntLaw:
    return learnt_law([log()])


def run(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> int:
    return exit_code(["design", *arguments], monkeypatch)


def test_the_formula_is_the_law() -> None:
    """What can be typed into a control gives the growth within what was held out."""
    found, frame = learnt(), log()
    formula = found.formula.partition("=")[2]
    for name in found.coefficients_um:
        slow = frame[f"{name}_temperature [degC]"].rolling(60, min_periods=1, center=True).mean()
        formula = formula.replace(f"T_{name}", f"slow[{name!r}]")
        globals().setdefault("_slow", {})[name] = slow
    growth = eval(formula, {"slow": globals()["_slow"]})
    error = (frame["growth [um]"] - growth)[60:]
    assert np.sqrt(np.mean(error**2)) < 1.5 * found.held_out_um
    assert found.coefficients_um.keys() == {"base", "middle", "tip"}


def test_growth_is_no_input() -> None:
    """The truth teaches nothing: with any other the same is learnt."""
    other = log().assign(**{"growth [um]": 0.0})
    assert learnt_law([other]).values == learnt().values
    without = log().drop(columns="growth [um]")
    assert learnt_law([without]).values == learnt().values


def test_the_figures_belong_together() -> None:
    found = learnt()
    told = found.to_dict()
    assert told["held_out_rms_um"] == pytest.approx(told["thermometers_rms_um"]["base, middle, tip"])
    assert found.held_out_um < 1.0
    assert found.worth_um.keys() == found.coefficients_um.keys()
    without_base = found.thermometers_um["middle, tip"] - found.held_out_um
    assert found.worth_um["base"] == pytest.approx(without_base)
    assert found.enough_min is not None
    for word in ("µm/K: base", "held-out blocks", "leaving out a thermometer costs", "min of log are enough"):
        assert word in found.summary()
    json.dumps(told, allow_nan=False)


def test_the_command_writes_parameters_and_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    one, two = tmp_path / "one.csv", tmp_path / "two.parquet"
    log(7200).drop(columns="growth [um]").to_csv(one, index=False)
    log().iloc[9000:].to_parquet(two)
    ssv, page = tmp_path / "mine.ssv", tmp_path / "mine.html"
    files = ["--out", str(ssv), "--report", str(page)]
    assert run(["--law", "regression", "--data", str(one), str(two), *files], monkeypatch) == 0
    said = capsys.readouterr().out
    assert "regression learnt from 2 logs of 4.5 h" in said
    values = {name: each.value for name, each in read_ssv(ssv).items()}
    assert values["coefficients[3]"] == pytest.approx(3e-6, rel=0.4)
    assert values["sensor_std[1]"] == 0.0
    text = page.read_text("utf-8")
    for part in ("worth their cable", "How much log is enough", "What the rest goes with", "T_base"):
        assert part in text


def test_the_notebook_learns_from_frames_and_runs(tmp_path: Path) -> None:
    found = wl.design(law="regression", data=log())
    assert isinstance(found, LearntLaw)
    assert found.values == learnt().values
    found.write(tmp_path / "a.ssv")
    compared = replayed([log(7200)], ["regression"], learn=[log()])
    assert compared.rows["regression", "data"].rms_um < 1.0


def test_what_was_learnt_is_not_blamed_on_a_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run with it once said that the law was designed for another cell."""
    from warmlink.orchestration.closed_loop.belief import design_check
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.scenarios.scenario import changed

    scenario = changed(load_scenario("warm_up"), controller="regression", parameters=learnt().parameters)
    assert design_check(scenario) == (None, False)


def test_a_model_helps_where_little_was_measured() -> None:
    short = log(900)
    plain = wl.design(law="regression", data=short)
    helped = wl.design(law="regression", data=short, parameters={"link.length": "340 mm"})
    assert isinstance(plain, LearntLaw)
    assert isinstance(helped, LearntLaw)
    assert helped.plant is not None
    assert "and the model of the scenario" in helped.summary()


def test_columns_may_have_other_names_and_units() -> None:
    frame = log().rename(columns={"base_temperature [degC]": "T1", "elongation [um]": "probe"})
    frame["T1"] = frame["T1"] * 1.8 + 32.0
    from warmlink.orchestration.diagnosis.data.options import read_options

    told = read_options(["T1=degF", "probe=um"], ["T1=base_temperature", "probe=elongation"])
    found = learnt_law([frame], options=told)
    assert found.coefficients_um["base"] == pytest.approx(learnt().coefficients_um["base"], rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["--law", "lag", "--data", "{log}"],
            "--law lag: is not learnt from a log; choose regression, observer or",
        ),
        (["--law", "regression", "--data", "absent.csv"], "absent.csv: no such file"),
        (
            ["--law", "regression", "--data", "{log}", "--sensors", "nose"],
            "no such thermometer; choose shaft, winding, base, middle or tip",
        ),
        (["--law", "regression", "--data", "{log}", "--out", "x.csv"], "is no parameter set"),
        (["--law", "regression", "--data", "{log}", "--replace", "link=a.fmu"], "has no model; leave it out"),
        (["--law", "regression"], "needs one system to design for, or logs: --data LOG"),
        (["WarmupCell", "--unit", "degC"], "--unit: belongs to --data"),
        (["--law", "regression", "--data", "{short}"], "thermometers; measure at least"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    log(3600).to_csv("log.csv", index=False)
    log(300).to_csv("short.csv", index=False)
    files = {"log": "log.csv", "short": "short.csv"}
    assert run([each.format(**files) for each in arguments], monkeypatch) == 2
    told = capsys.readouterr().err
    assert said in told
    assert "Traceback" not in told
    assert not list(tmp_path.glob("*.ssv"))


def test_a_log_without_growth_says_what_is_missing() -> None:
    bare = log().drop(columns=["elongation [um]", "growth [um]"])
    with pytest.raises(InputError, match="the growth was not measured; add a column 'elongation"):
        learnt_law([bare])


def test_a_slow_log_teaches_too() -> None:
    """A row each minute, as many loggers write them."""
    slow = log().iloc[::60].reset_index(drop=True)
    found: Any = learnt_law([slow])
    assert found.held_out_um < 1.5
    assert sum(found.coefficients_um.values()) == pytest.approx(
        sum(learnt().coefficients_um.values()), rel=0.05
    )


@cache
def strangers(name: str) -> tuple[pd.DataFrame, list[MeasuredLog]]:
    """What a machine teaches, and the logs that it is judged on."""
    folder = given("machine")
    training = folder / f"{name}_training.parquet"
    return pd.read_parquet(training), read_logs(sorted(set(folder.glob(f"{name}_*")) - {training}))


@pytest.mark.slow
@pytest.mark.parametrize(("minutes", "removed", "rms"), [(300, 98.6, 0.8), (30, 97.5, 1.2)])
def test_a_strangers_machines_are_learnt(minutes: int, removed: float, rms: float) -> None:
    """Logs of a plant that shares nothing with this project's: the issue's bounds."""
    law, figures = controllers()["regression"], []
    for taught, others in map(strangers, ("machine1", "machine2")):
        values = learnt_law([taught[taught["time [s]"] <= 60 * minutes]]).parameters
        own = {name.partition(".")[2]: value for name, value in values.items()}
        learnt = replace(law, parameters=with_scalars(law.parameters, own))
        figures += [replay_figures(learnt, each, 5e-6) for each in others]
    assert np.median([each.removed_percent for each in figures if each.removed_percent]) >= removed
    assert np.median([each.rms_um for each in figures]) <= rms
    assert max(each.worst_um for each in figures) <= 10
    assert np.mean([each.outside_percent for each in figures]) <= 1
    assert np.mean([each.ready_wrong_percent for each in figures]) <= 1
    assert np.mean([each.fine_not_ready_percent for each in figures]) <= 10


@pytest.mark.parametrize("law", ["observer", "observer_drift"])
def test_an_observer_learns_the_same_map(law: str) -> None:
    """Its growth by the temperatures is the regression's: coefficients and intercept."""
    from warmlink.controllers.interface import SENSED

    found, known = learnt_law([log()], law).values, learnt().learnt.values
    rows = np.array(found["sensor_rows"]).reshape(len(SENSED), -1)
    assert found["elongation_row"] == pytest.approx(np.array(known["coefficients"]) @ rows)
    by_all = found["elongation_per_kelvin"]
    assert isinstance(by_all, float)
    assert by_all == pytest.approx(np.sum(known["coefficients"]))
    at_reference = by_all * (295.15 - float(found["reference_temperature"]))  # type: ignore[arg-type]
    assert at_reference == pytest.approx(known["intercept"])
    assert found["learnt"] == 1.0
