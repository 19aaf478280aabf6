"""`warmlink simulate` with FMUs that do what an FMU must not do: nothing computed is lost, and it is said."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from tests.warm import ran
from warmlink.orchestration.system.model import Connection, DefaultExperiment, FmuPart, System, Value
from warmlink.orchestration.system.write import write_ssp

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="runs are guarded on Linux"),
    pytest.mark.usefixtures("in_a_fresh_folder"),
]

COMMAND = [sys.executable, "-m", "warmlink.orchestration.cli", "simulate"]
SHORT_WAIT = """
from warmlink.orchestration.cli import main
from warmlink.orchestration.master import guard

guard.ENDING_SECONDS = 0.3
main()
"""
STEPS = 10
ALONE = ["--no-error-budget"]


def two(fmu: Path, second: str = "b", **values: Value) -> Path:
    """Two integrators, the second fed by the first; the values are the second's."""
    parts = {"a": FmuPart("a", fmu), second: FmuPart(second, fmu, {}, dict(values))}
    path = Path("two.ssp")
    wires = (Connection("a", "y", second, "u"),)
    write_ssp(System("two", parts, wires, DefaultExperiment(0.0, 1.0, 1.0 / STEPS)), path)
    return path


def simulate(path: Path, *options: str, hurried: bool = False) -> subprocess.CompletedProcess[str]:
    arguments = ["simulate", str(path), "--out", "o", *options]
    if hurried:
        command = [sys.executable, "-c", SHORT_WAIT, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    else:
        done = ran(*arguments)
    assert "Traceback" not in done.stderr
    return done


def rows() -> int:
    found = len(pd.read_csv("o/results.csv"))
    assert len(pd.read_parquet("o/results.parquet")) == found
    return found


@pytest.fixture(scope="module")
def whole(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """What the two give where neither misbehaves, however they are stepped."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("whole"))
        assert simulate(two(fmu), *ALONE).returncode == 0
        return pd.read_csv("o/results.csv")


@pytest.mark.parametrize("stepping", ["plain", "compiled"])
@pytest.mark.parametrize(
    ("status", "how"), [(8, "exit code 0"), (5, "signal SIGSEGV")], ids=["exit", "crash"]
)
def test_an_fmu_that_ends_the_process_is_named_and_the_values_are_kept(
    fmu: Path, status: int, how: str, stepping: str
) -> None:
    done = simulate(two(fmu, fail_at=0.55, fail_status=status), *ALONE, "--stepping", stepping)
    assert done.returncode == 1
    assert f"stopped early: b: crash at 0.5 s: its process ended ({how}) in a step" in done.stderr
    assert rows() == 6


def test_a_crash_says_which_streamed_values_are_lost(fmu: Path) -> None:
    options = ("--checkpoint", "2", "--step", "0.1 s")
    done = simulate(two(fmu, fail_at=0.55, fail_status=5), *ALONE, *options)
    assert done.returncode == 1
    assert "the values after 0.4 s were not on disk yet and are lost" in done.stderr
    assert rows() == 5


@pytest.mark.parametrize(
    ("label", "how"),
    [
        ("crash in terminate", "ended (signal SIGSEGV)"),
        ("crash in free", "ended (signal SIGSEGV)"),
        ("hang in free", "did not end within 0.3 s"),
    ],
)
def test_an_fmu_that_fails_when_it_is_freed_costs_no_values(fmu: Path, label: str, how: str) -> None:
    done = simulate(two(fmu, label=label), *ALONE, "--json", hurried=label.startswith("hang"))
    assert done.returncode == 0, done.stderr
    assert f"b: its process {how}" in done.stderr
    assert "the values are complete" in done.stderr
    assert json.loads(done.stdout)["stop_time_s"] == 1.0
    assert rows() == STEPS + 1


@pytest.mark.parametrize(
    ("status", "what"),
    [(9, "the working folder"), (10, "how numbers are rounded"), (11, "the locale")],
    ids=["folder", "rounding", "locale"],
)
@pytest.mark.parametrize("stepping", ["plain", "compiled"])
def test_an_fmu_that_changes_what_others_share_is_named_and_changes_no_digit(
    fmu: Path, whole: pd.DataFrame, status: int, what: str, stepping: str
) -> None:
    done = simulate(two(fmu, fail_at=0.0, fail_status=status), *ALONE, "--stepping", stepping)
    assert done.returncode == 0, done.stderr
    assert f"b: in a step it changed {what}" in done.stderr
    # Its own arithmetic, in the step in which it changed the rounding, is its own affair.
    same = ["time [s]", "a.y [1]", "a.z [1]"]
    assert pd.read_csv("o/results.csv")[same].equals(whole[same])


@pytest.mark.parametrize("stepping", ["plain", "compiled"])
@pytest.mark.parametrize("status", [10, 19, 20], ids=["rounding", "traps", "small numbers"])
def test_an_fmu_that_changes_arithmetic_late_is_named_once_and_changes_no_digit(
    fmu: Path, whole: pd.DataFrame, status: int, stepping: str
) -> None:
    done = simulate(two(fmu, fail_at=0.45, fail_status=status), *ALONE, "--stepping", stepping)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("b: in a step it changed ") == 1
    assert pd.read_csv("o/results.csv")["a.y [1]"].equals(whole["a.y [1]"])


@pytest.mark.parametrize("options", [[], ["--isolate"]], ids=["guarded", "isolated"])
def test_what_an_fmu_prints_does_not_mix_with_the_answer(fmu: Path, options: list[str]) -> None:
    done = simulate(two(fmu, fail_at=0.0, fail_status=12), "--json", *options)
    assert json.loads(done.stdout)["stop_time_s"] == 1.0
    assert "printed by the FMU" in done.stderr


@pytest.mark.parametrize("options", [[], ["--isolate"]], ids=["guarded", "isolated"])
def test_an_fmu_that_forks_leaves_one_run(fmu: Path, options: list[str]) -> None:
    done = simulate(two(fmu, fail_at=0.45, fail_status=13), "--json", *ALONE, *options)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["stop_time_s"] == 1.0
    assert rows() == STEPS + 1


BOTH = pytest.mark.parametrize("options", [[], ["--isolate"]], ids=["guarded", "isolated"])


@BOTH
def test_an_fmu_that_writes_into_low_descriptors_reaches_nothing(
    fmu: Path, whole: pd.DataFrame, options: list[str]
) -> None:
    done = simulate(two(fmu, fail_at=0.45, fail_status=16), *ALONE, *options)
    assert (done.returncode, done.stderr) == (0, "")
    assert pd.read_csv("o/results.csv").equals(whole)


@BOTH
def test_an_fmu_that_writes_into_every_descriptor_is_named(fmu: Path, options: list[str]) -> None:
    done = simulate(two(fmu, fail_at=0.45, fail_status=17), *ALONE, *options)
    assert done.returncode == 1
    assert "stopped early: b: crash at 0.4 s: " in done.stderr
    assert "the FMU writes to descriptors that are not its own" in done.stderr
    assert rows() == 5


RESTORING = ["crash in restore", "exit in restore", "discard in restore", "no state"]


def loop_of(fmu: Path, stop: float = 1.0, **values: Value) -> Path:
    """Two integrators that feed each other, whose stability is looked at after the run."""
    parts = {"a": FmuPart("a", fmu), "b": FmuPart("b", fmu, {}, dict(values))}
    wires = (Connection("a", "y", "b", "u"), Connection("b", "y", "a", "u", -1.0))
    path = Path("loop.ssp")
    write_ssp(System("loop", parts, wires, DefaultExperiment(0.0, stop, 1.0 / STEPS)), path)
    return path


@BOTH
@pytest.mark.parametrize("label", RESTORING)
def test_an_fmu_that_does_not_go_back_costs_no_values(fmu: Path, label: str, options: list[str]) -> None:
    done = simulate(loop_of(fmu, label=label), *ALONE, *options)
    assert done.returncode == 0, done.stderr
    assert "b: " in done.stderr
    assert rows() == STEPS + 1


def test_an_isolated_fmu_that_hangs_while_it_goes_back_costs_no_values(fmu: Path) -> None:
    done = simulate(loop_of(fmu, label="hang in restore"), *ALONE, "--isolate", "--time-limit", "1 s")
    assert done.returncode == 0, done.stderr
    assert "whether these steps are stable is not known: b: time limit at 0.9 s: restore" in done.stderr
    assert rows() == STEPS + 1


@pytest.mark.parametrize("stepping", ["plain", "compiled"])
def test_an_fmu_that_cannot_go_back_says_when(fmu: Path, stepping: str) -> None:
    path = loop_of(fmu, 2.0, label="discard in restore", fail_at=1.55, fail_status=2)
    done = simulate(path, *ALONE, "--stepping", stepping)
    assert done.returncode == 1
    assert "stopped early: b: discard at 1.5 s: fmi2SetFMUState answered discard" in done.stderr


@pytest.mark.parametrize(
    ("label", "how"),
    [
        ("crash in terminate", "its process died in terminate (signal SIGSEGV), after the run"),
        ("crash in free", "its process died in terminate (signal SIGSEGV), after the run"),
        ("hang in free", "terminate has not returned within 1 s; its process was ended, after the run"),
    ],
)
def test_an_isolated_fmu_that_fails_when_it_is_freed_is_named(fmu: Path, label: str, how: str) -> None:
    done = simulate(two(fmu, label=label), *ALONE, "--isolate", "--time-limit", "1 s", "--json")
    assert done.returncode == 0, done.stderr
    assert f"b: {how}; the values are complete" in done.stderr
    assert len(json.loads(done.stdout)["remarks"]) == 1
    assert rows() == STEPS + 1


def test_an_isolated_fmu_that_writes_beyond_its_memory_is_not_said_to_need_more(fmu: Path) -> None:
    done = simulate(two(fmu, fail_at=0.45, fail_status=18), *ALONE, "--isolate")
    assert done.returncode == 1
    told = "b: crash at 0.4 s: its process died in step (signal SIGABRT; it wrote beyond its memory"
    assert told in done.stderr
    assert rows() == 5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "presses", "busy_for"),
    [([], 2, 0.5), (["--isolate"], 1, 1.5)],  # the latter begins as Python does
    ids=["guarded", "isolated"],
)
def test_ctrl_c_ends_an_endless_step_and_keeps_the_values(
    fmu: Path, options: list[str], presses: int, busy_for: float
) -> None:
    path = two(fmu, fail_at=0.55, fail_status=6)
    with subprocess.Popen(
        [*COMMAND, str(path), "--out", "o", *ALONE, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        wait_for_load(process.pid, busy_for)
        process.send_signal(signal.SIGINT)
        assert process.stderr is not None
        assert any("press again to end it at once" in line for line in process.stderr)
        if presses == 2:
            process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 1
    assert "interrupted at 0.5 s" in err
    assert "Traceback" not in err
    assert rows() == 6


def wait_for_load(pid: int, seconds: float) -> None:
    """Wait until a process below this one has worked for so long."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        if any(busy(child) > seconds for child in descendants(pid)):
            return
        time.sleep(0.05)
    raise AssertionError("no FMU is at work")


def descendants(pid: int) -> list[int]:
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, path.read_text().split()):
            found += [child, *descendants(child)]
    return found


def busy(pid: int) -> float:
    """Processor time in s that a process has had."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_the_time_limit_covers_instantiation(fmu: Path) -> None:
    done = simulate(two(fmu, "endless"), "--isolate", "--time-limit", "1 s")
    assert done.returncode == 1
    assert "endless: time limit at 0 s: instantiating has not returned within 1 s" in done.stderr
    assert "there are no results" in done.stderr


def test_an_isolated_fmu_that_takes_all_memory_is_named(fmu: Path) -> None:
    path = two(fmu, fail_at=0.55, fail_status=14)
    done = simulate(path, "--isolate", "--memory-limit", "300 MB", *ALONE)
    assert done.returncode == 1, done.stderr
    assert "b: crash at 0.5 s: its process died in step (signal SIGABRT;" in done.stderr
    assert "memory limit was 300 MB" in done.stderr
    assert rows() == 6


@pytest.mark.parametrize("folder", ["o", "-o"], ids=["plain", "read by typer"])
def test_ctrl_c_before_there_is_anything_says_so(tmp_path: Path, folder: str) -> None:
    script = (
        "import signal, time, warmlink.orchestration.cli as cli, warmlink.orchestration.fmu_store as fmus\n"
        # A suite that runs in the background ignores the signal; a sleep ends with what its handler raises.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "fmus.store = lambda *given: (signal.raise_signal(signal.SIGINT), time.sleep(60))\n"
        "cli.main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "run", f"--out={folder}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 130
    assert done.stderr == "warmlink: interrupted; there are no results\n"
    assert not Path(folder).exists()
