"""What `warmlink run` says about its own figures: when they flatter, when the law is the wrong one."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from warmlink.controllers.design.shipped import PLANT_FACTS
from warmlink.controllers.start_values import design_file
from warmlink.orchestration.catalogue import controllers
from warmlink.orchestration.cli import main
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.machine.shipped import WARMUP_CELL

MY_LAW = Path(__file__).parent / "studies" / "my_law.py"
STEEL = ["--set", "link.length=800 mm", "--set", "link.tip_position=790 mm", "--set", "link.conductivity=50"]
NOMINAL = "windshield_wiper"
SHORT = ["--stop", "20 min", "--no-report"]

Warmlink = Callable[..., tuple[int, str]]


@pytest.fixture
def warmlink(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Warmlink:
    """The command in a folder of its own: its exit code and what it printed."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str]:
        monkeypatch.setattr("sys.argv", ["warmlink", *arguments])
        capsys.readouterr()
        try:
            main()
            code = 0
        except SystemExit as stop:
            code = int(stop.code or 0)
        return code, "".join(capsys.readouterr())

    return run


def metrics(folder: str) -> dict[str, object]:
    found: dict[str, object] = json.loads((Path(folder) / "metrics.json").read_text("utf-8"))
    return found


def test_no_controller_acts_on_motor_or_link() -> None:
    # So one run gives the error with a controller and without: it is the elongation.
    reached, new = set[str](), {COMPENSATOR}
    while new - reached:
        reached |= new
        new = {
            target.partition(".")[0]
            for source, target in WARMUP_CELL.wires
            if source.partition(".")[0] in reached
        }
    assert reached == {COMPENSATOR, "camera"}


def test_every_law_that_ships_with_a_design_says_what_it_knows_of_the_plant() -> None:
    assert set(PLANT_FACTS) == {name for name in controllers() if design_file(name).is_file()}


def test_the_default_run_loads_no_designer() -> None:
    script = (
        "import sys\n"
        "from dataclasses import replace\n"
        "from warmlink.orchestration.catalogue import shipped\n"
        "from warmlink.orchestration.closed_loop.belief import design_check\n"
        "from warmlink.orchestration.closed_loop.load import load_scenario\n"
        "for law in ('lag', 'observer'):\n"
        f"    design_check(replace(load_scenario('{NOMINAL}'), controller=shipped(law)))\n"
        "print('scipy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_a_perfect_cell_is_called_one(warmlink: Warmlink) -> None:
    code, printed = warmlink("run", NOMINAL, "--controller", "observer", "--stop", "20 min", "--out", "o")
    assert code == 0
    assert "the thermometers are perfect and the cell is exactly the one" in printed
    assert "removed" not in printed, "a share of an error within the error budget means nothing"
    assert "The thermometers are perfect" in Path("o/report.html").read_text("utf-8")
    assert metrics("o")["reduction_percent"] is None


@pytest.mark.parametrize("law", ["observer", "regression"])
def test_a_cell_in_a_cold_hall_is_another_cell_and_can_be_designed_for(warmlink: Warmlink, law: str) -> None:
    segment = 'duration = "10 min"\nambient_temperature = "15 degC"\n'
    parts = ("link.initial", "motor.initial_shaft", "motor.initial_winding")
    Path("cold.toml").write_text(
        f'stop_time = "20 min"\nstep_size = "5 s"\nrepeat = true\ncontroller = "{law}"\n'
        f'[[segment]]\nspeed = "3 rad/s"\ntorque = "2.5 N.m"\n{segment}[[segment]]\n{segment}[parameters]\n'
        + "".join(f'"{part}_temperature" = "15 degC"\n' for part in parts)
    )
    _, printed = warmlink("run", "cold.toml", "--no-report", "--out", "before")
    assert f"{law} was designed for another cell; this one differs in link.initial_temperature" in printed
    warmlink("design", "cold.toml", "--law", law, "--out", "cold.ssv")
    _, printed = warmlink("run", "cold.toml", "--no-report", "--parameters", "cold.ssv", "--out", "after")
    assert "designed for another cell" not in printed
    largest = [metrics(name)["compensated"]["max_abs_um"] for name in ("before", "after")]  # type: ignore[index]
    assert largest[0] > 40
    assert largest[1] < 3


def test_a_tolerance_below_the_coupling_error_makes_the_steps_follow_it(warmlink: Warmlink) -> None:
    _, kept = warmlink("run", "--stop", "10 s", "--tolerance", "0.1 um", "--no-report")
    assert "1 s steps · gauss_seidel" in kept
    _, found = warmlink("run", "--stop", "10 s", "--tolerance", "1e-4 um", "--no-report")
    assert "1 s steps · error_controlled" in found
    assert "not within the tolerance" not in found


@pytest.mark.parametrize("mismatch", [["thermal_high"], ["noisy_sensors"], ["thermal_high", "noisy_sensors"]])
def test_a_mismatch_is_that_of_compare(warmlink: Warmlink, mismatch: list[str]) -> None:
    chosen = [part for name in mismatch for part in ("--mismatch", name)]
    code, printed = warmlink("run", NOMINAL, "--controller", "observer", *chosen, *SHORT, "--out", "o")
    assert code == 0
    assert " · ".join(mismatch) in printed
    assert "note" not in printed
    found = metrics("o")
    assert found["mismatches"] == mismatch
    if len(mismatch) > 1:
        return
    Path("duty.toml").write_text('duty = "windshield_wiper"\nstop_time = "20 min"\n')
    study = ["--controllers", "observer", "--duty-cycles", "duty.toml", "--mismatch", *mismatch, "--exact"]
    warmlink("compare", *study)
    row = Path("out/compare/compare.csv").read_text("utf-8").splitlines()[2].split(",")
    compensated = found["compensated"]
    assert isinstance(compensated, dict)
    assert row[0] == "observer"
    assert float(row[3]) == pytest.approx(compensated["max_abs_um"], abs=1e-6)


def test_a_law_for_another_cell_is_told_with_the_command_that_mends_it(warmlink: Warmlink) -> None:
    worse, printed = warmlink("run", NOMINAL, "--controller", "observer", *STEEL, *SHORT, "--out", "o")
    assert worse == 0
    note = next(line for line in printed.splitlines() if line.startswith("note  observer was designed for"))
    assert "link.length, link.tip_position and link.conductivity" in note
    command = note.partition("design it anew: warmlink ")[2].partition("; then add ")
    assert warmlink(*shlex.split(command[0]))[0] == 0
    before = metrics("o")["compensated"]
    code, printed = warmlink(
        "run", NOMINAL, "--controller", "observer", *STEEL, *shlex.split(command[2]), *SHORT, "--out", "o"
    )
    after = metrics("o")["compensated"]
    assert code == 0
    assert "was designed for another" not in printed
    assert isinstance(before, dict)
    assert isinstance(after, dict)
    assert after["max_abs_um"] < 0.1 * before["max_abs_um"]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            ["--controller", "lag", "--set", "link.length=800 mm"],
            "the parameters of lag suit the nominal cell",
        ),
        (["--controller", "lag", "--set", "link.length=800 mm", "--set", "compensator.gain=7 um/W"], None),
        (["--controller", "lag", "--set", "link.initial_temperature=30 degC"], None),
        (["--controller", "lag"], None),
        (["--controller", "regression", *STEEL], "regression was designed for another cell"),
        (["--controller", "observer", "--set", "link.length=330.2 mm"], None),
        (
            ["--controller", "observer", "--set", "compensator.coulomb_friction=3"],
            "this one is the nominal one",
        ),
        (["--controller", "observer", "--mismatch", "thermal_high"], None),
        (["--controller", "none", *STEEL], None),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_advice_is_given_where_the_cell_is_another_and_not_elsewhere(
    warmlink: Warmlink, arguments: list[str], told: str | None
) -> None:
    code, printed = warmlink("run", NOMINAL, *arguments, "--stop", "1 min", "--no-report")
    assert code == 0
    if told is None:
        assert "warmlink design" not in printed
    else:
        assert told in printed


def test_no_share_of_an_error_that_is_none(warmlink: Warmlink) -> None:
    code, printed = warmlink("run", NOMINAL, "--stop", "10", "--no-report")
    assert code == 0
    assert "worse" not in printed
    assert "0.0 µm         0.4 µm" in printed


def test_a_law_of_ones_own_runs_by_its_place(warmlink: Warmlink) -> None:
    code, printed = warmlink("run", NOMINAL, "--controller", f"{MY_LAW}:MyLaw", *SHORT, "--out", "o")
    assert code == 0
    assert printed.splitlines()[1].split() == ["none", "MyLaw"]
    assert metrics("o")["controller"] == "MyLaw"
    arm = ("six_axis_shift", "--controller", f"{MY_LAW}:MyLaw", "--stop", "1 min", "--no-report")
    code, printed = warmlink("run", *arm, "--out", "arm")
    assert code == 0
    assert metrics("arm")["controller"] == "MyLaw"


def pressing(share: float, times: int) -> Callable[[str], object]:
    """A progress bar that presses Ctrl-C when so much of the work is done."""

    @contextmanager
    def bar(what: str) -> Iterator[Callable[[float], None]]:
        left = times

        def show(done: float) -> None:
            nonlocal left
            while done >= share and left:
                left -= 1
                os.kill(os.getpid(), signal.SIGINT)

        yield show

    return bar


def test_ctrl_c_in_the_run_at_half_the_step_costs_the_bound_alone(
    warmlink: Warmlink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.closed_loop.outcome.progress_bar", pressing(0.5, 1))
    short = ("--stop", "3 min", "--no-report", "--fmus", "python")
    code, printed = warmlink("run", NOMINAL, *short, "--out", "o")
    assert code == 1
    assert "in the run at half the step; what was computed up to there is kept" in printed
    assert "describe that part" not in printed
    assert float(str(metrics("o")["simulated_s"])) == 180


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_keeps_what_was_computed(
    warmlink: Warmlink, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    monkeypatch.setattr("warmlink.orchestration.closed_loop.outcome.progress_bar", pressing(0.1, times))
    code, printed = warmlink("run", NOMINAL, "--stop", "5 min", "--fmus", "python", "--out", "o")
    assert code == 1
    assert "of 5 min" in printed
    assert "stopped early: interrupted at" in printed
    assert "the figures above describe that part only" in printed
    found = metrics("o")
    assert 0 < float(str(found["simulated_s"])) < 300
    # There is a live page, too, where the system was compiled for the browser before.
    assert {path.name for path in Path("o").iterdir()} - {"live.html"} == {
        "command.txt",
        "metrics.json",
        "report.html",
        "results.csv",
        "results.parquet",
    }
    assert "Stopped early: interrupted at" in Path("o/report.html").read_text("utf-8")


@pytest.mark.slow
def test_ctrl_c_in_the_second_run_costs_the_coupling_error_alone(
    warmlink: Warmlink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("warmlink.orchestration.closed_loop.outcome.progress_bar", pressing(0.6, 1))
    code, printed = warmlink("run", NOMINAL, "--stop", "3 min", "--fmus", "python", "--out", "o")
    assert code == 1
    assert "in the run at half the step" in printed
    found = metrics("o")
    assert found["simulated_s"] == 180
    assert '"coupling": null' in Path("o/metrics.json").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "--mismatch", "termal_high"], "termal_high: no such mismatch; did you mean thermal_high?"),
        (["run", "--controller", "mine.py"], "mine.py: names no law; write it as my_law.py:MyLaw"),
        (["run", "--controller", "mine.py:Law"], "mine.py:Law: there is no file mine.py"),
        (
            ["run", "extended.ssp"],
            "is no scenario; it is a system: warmlink simulate extended.ssp",
        ),
        (["design", "WarmupCell", "--set", "link.lenght=1"], "did you mean length?"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_cannot_be_run_says_what_can(warmlink: Warmlink, arguments: list[str], sentence: str) -> None:
    Path("extended.ssp").write_bytes(b"PK")
    code, printed = warmlink(*arguments)
    assert code == 2
    assert sentence in printed
    assert sorted(path.name for path in Path().iterdir()) == ["extended.ssp"]
