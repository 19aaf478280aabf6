"""`warmlink compare --data` and `wl.compare(data=...)`: laws judged on measured logs, without a plant."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import warmlink as wl
from benchmarks.strange_machine import Demand, Machine, training
from benchmarks.strange_machine import logs as logs_of
from tests.command import exit_code
from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controllers
from warmlink.orchestration.replay.compare import Replayed, replay_figures, replayed
from warmlink.orchestration.replay.learn import learnt_law
from warmlink.orchestration.replay.logs import read_logs


@cache
def log() -> pd.DataFrame:
    return Machine(2).run([Demand(5400, 3.4, 2.5), Demand(1800)], 1).log()


@cache
def taught() -> pd.DataFrame:
    return Machine(2).run(training(), 2).log()


@cache
def strange_logs() -> dict[str, pd.DataFrame]:
    return dict(logs_of(5))


def run(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> int:
    return exit_code(["compare", *arguments], monkeypatch)


def test_without_compensation_the_error_is_the_growth() -> None:
    (read,) = read_logs([log()])
    found = replay_figures(controllers()["none"], read, 5e-6)
    late = log().iloc[121:]["growth [um]"]
    assert found.worst_um == pytest.approx(late.abs().max(), rel=1e-3)
    assert found.rms_um == pytest.approx(np.sqrt(np.mean(late**2)), rel=1e-3)
    assert found.outside_percent == pytest.approx(100 * (late.abs() > 5).mean(), abs=0.1)
    assert found.ready_percent == 0
    assert found.travel_um_h == 0


def test_a_law_that_learnt_from_another_log_is_far_better() -> None:
    found = replayed([log()], ["none", "regression"], learn=[taught()])
    none, regression = (found.rows[name, "data"] for name in found.controllers)
    assert regression.rms_um < 0.02 * none.rms_um
    assert regression.removed_percent is not None
    assert regression.removed_percent > 97.5
    assert regression.travel_um_h < 100
    assert regression.ready_wrong_percent == 0


def test_no_law_of_ours_is_worse_than_the_regression() -> None:
    """With the same thermometers and log: at most a tenth, and more thermometers make none worse."""
    strange = strange_logs()
    names, others = ["regression", "observer", "observer_drift"], ["random_shift", "heavy_shift", "draught"]
    found = replayed([strange[name] for name in others], names, learn=[strange["training"]])
    rms = {name: found.over_all(name)["rms_um"] for name in names}
    assert max(rms.values()) <= 1.1 * rms["regression"] + 0.02
    assert all(found.over_all(name)["ready_wrong_percent"] <= 1 for name in names)
    assert all(found.over_all(name)["fine_not_ready_percent"] <= 10 for name in names)
    assert found.over_all("observer")["travel_um_h"] < 100


def test_more_thermometers_make_no_law_worse() -> None:
    strange = strange_logs()
    read = read_logs([strange[name] for name in ("random_shift", "draught", "hot_workpieces", "winter")])
    rms = []
    for sensors in (
        ["base", "tip"],
        ["base", "middle", "tip"],
        ["shaft", "winding", "base", "middle", "tip"],
    ):
        values = learnt_law([strange["training"]], sensors=sensors).parameters
        own = {name.partition(".")[2]: value for name, value in values.items()}
        law = controllers()["regression"]
        law = replace(law, parameters=with_scalars(law.parameters, own))
        rms.append(np.sqrt(np.mean([replay_figures(law, log, 5e-6).rms_um ** 2 for log in read])))
    assert rms[1] <= 1.05 * rms[0]
    assert rms[2] <= 1.05 * rms[0]


def test_the_truth_is_judged_by_and_never_seen() -> None:
    """With another truth the same corrections are judged otherwise."""
    shifted = log().assign(**{"growth [um]": log()["growth [um]"] + 3.0})
    one, other = (
        replayed([each], ["observer_drift"]).rows["observer_drift", "data"] for each in (log(), shifted)
    )
    assert one.travel_um_h == other.travel_um_h
    assert other.rms_um > one.rms_um + 1.0


def test_without_a_truth_the_measured_growth_is_judged_by() -> None:
    bare = log().drop(columns="growth [um]")
    whole, measured = (replayed([each], ["observer"]).rows["observer", "data"] for each in (log(), bare))
    assert measured.rms_um == pytest.approx(whole.rms_um, rel=0.1)
    assert measured.travel_um_h == whole.travel_um_h


def test_a_camera_sees_the_growth_less_its_own_correction() -> None:
    blind = log().drop(columns="elongation [um]")
    seen, unseen = (
        replayed([each], ["observer_drift"]).rows["observer_drift", "data"] for each in (log(), blind)
    )
    assert seen.rms_um < 0.3 * unseen.rms_um


def test_a_log_slower_than_the_law_slows_it() -> None:
    """A reading that is held for a minute once looked stuck, and was left out."""
    slow = log().iloc[::60].reset_index(drop=True)
    found = replayed([slow], ["regression"], learn=[taught()]).rows["regression", "data"]
    assert found.rms_um < 2.0


def test_start_values_reach_the_laws_that_have_them() -> None:
    values = learnt_law([taught()]).parameters
    found = wl.compare(["regression", "lag"], data=log(), parameters=values)
    assert isinstance(found, Replayed)
    assert found.rows["regression", "data"].rms_um < 1.5
    law = controllers()["regression"]
    own = replace(
        law,
        parameters=with_scalars(law.parameters, {k.partition(".")[2]: v for k, v in values.items()}),
    )
    (read,) = read_logs([log()])
    assert replay_figures(own, read, 5e-6) == found.rows["regression", "data"]


def test_the_tolerance_is_the_laws_too() -> None:
    strict, loose = (
        replayed([log()], ["regression"], learn=[taught()], tolerance=t) for t in ("0.5 um", "9 um")
    )
    assert strict.rows["regression", "data"].ready_percent < 5
    assert loose.rows["regression", "data"].ready_percent > 95
    assert strict.tolerance_um == pytest.approx(0.5)


def test_the_command_writes_table_and_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        log().to_parquet(f"{name}.parquet")
    taught().to_parquet("taught.parquet")
    common = ["--controllers", "lag,regression", "--learn", "taught.parquet", "--out", "found"]
    assert run(["--data", "one.parquet", "two.parquet", *common], monkeypatch) == 0
    said = capsys.readouterr().out
    assert "2 measured logs, tolerance ±5 µm" in said
    assert "removed, median" in said
    table = pd.read_csv("found/logs.csv")
    assert len(table) == 4
    assert set(table["log"]) == {"one", "two"}
    assert "Controllers judged on measured logs" in Path("found/report.html").read_text("utf-8")
    assert run(["--data", "one.parquet", *common, "--json", "--no-report"], monkeypatch) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["laws"]["regression"]["rms_um"] < told["laws"]["lag"]["rms_um"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--data", "log.csv", "--duty-cycles", "stop_and_go"], "--data: measured logs are compared as they"),
        (["--data", "absent.csv"], "absent.csv: no such file"),
        (["--data", "log.csv", "--controllers", "magic"], "magic: no such controller"),
        (["--data", "log.csv", "--tolerance", "5 K"], "--tolerance"),
        (["--data", "log.csv", "--set", "compensator.nose=3"], "nose"),
        (["--data", "log.toml"], "is no log; give a file of measurements"),
        (["--learn", "log.csv"], "are for measured logs; give them with --data LOG"),
        (["--tolerance", "3 um"], "are for measured logs; give them with --data LOG"),
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
    log().iloc[:1200].to_csv("log.csv", index=False)
    assert run(arguments, monkeypatch) == 2
    told = capsys.readouterr().err
    assert said in told
    assert "Traceback" not in told
    assert not Path("out").exists() or not list(Path("out").rglob("*.csv"))


def test_a_log_without_growth_cannot_judge() -> None:
    bare = log().drop(columns=["growth [um]", "elongation [um]"])
    with pytest.raises(InputError, match="the growth was measured 0 times after the first 2 min"):
        replayed([bare], ["none"])


def test_two_laws_of_one_name_are_refused(tmp_path: Path) -> None:
    """One row was left, that of the second."""
    law = (Path(__file__).parents[1] / "studies" / "my_law.py").read_text()
    for name in ("one", "two"):
        (tmp_path / f"{name}.py").write_text(f"# {name}\n{law}")
    places = [f"{tmp_path / name}.py:MyLaw" for name in ("one", "two")]
    assert replayed([log()], places[0]).controllers == ("MyLaw",)
    with pytest.raises(InputError, match=r"^MyLaw: two controllers of that name; rename one$"):
        replayed([log()], places)


def test_logs_of_one_name_stay_apart(tmp_path: Path) -> None:
    """The first and the last had one name, so that the last counted twice and the first not at all."""
    for i, place in enumerate(("day/shift.csv", "night/shift.csv", "shift (1).csv"), 1):
        (tmp_path / place).parent.mkdir(exist_ok=True)
        log().iloc[: 1200 * i].to_csv(tmp_path / place, index=False)
    found = read_logs([tmp_path / place for place in ("day/shift.csv", "night/shift.csv", "shift (1).csv")])
    assert [each.name for each in found] == ["shift (2)", "shift (3)", "shift (1)"]
    assert [each.time.size for each in found] == [1200, 2400, 3600]


def test_the_only_log_needs_no_list(tmp_path: Path) -> None:
    path = str(tmp_path / "one.csv")
    log().to_csv(path, index=False)
    assert replayed(path, "lag").logs == ("one",)
    assert learnt_law(path).source.startswith("learnt from one.csv (")
    assert wl.cnc_table("regression", data=path).measured


def test_start_values_reach_a_law_of_ones_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its table was written, and then its name was said to be that of no controller."""
    monkeypatch.chdir(tmp_path)
    log().to_csv("one.csv", index=False)
    Path("my.py").write_text((Path(__file__).parents[1] / "studies" / "my_law.py").read_text())
    given = ["--controllers", "my.py:MyLaw", "--set", "compensator.gain=7 um/K", "--no-report"]
    assert run(["--data", "one.csv", *given], monkeypatch) == 0
    assert "for MyLaw" in capsys.readouterr().err


def test_what_is_for_logs_is_refused_without_them_and_the_other_way_round(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="`tolerance`: is for measured logs; give them as `data`"):
        wl.compare(["lag"], ["stop_and_go"], ["nominal"], tolerance="3 um")
    with pytest.raises(InputError, match="`learn`: is for measured logs"):
        wl.compare(["lag"], ["stop_and_go"], ["nominal"], learn=log())
    with pytest.raises(InputError, match="`out`: measured logs are compared as they are"):
        wl.compare(["lag"], data=log(), out=tmp_path)


def test_logs_may_be_given_as_they_are_made(tmp_path: Path) -> None:
    log().to_csv(tmp_path / "one.csv", index=False)
    found = wl.compare(["none"], data=tmp_path.glob("*.csv"))
    assert isinstance(found, Replayed)
    assert list(found.rows) == [("none", "one")]
