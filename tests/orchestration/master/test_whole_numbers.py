"""Integers of 64 bits stay what they are, beyond what a double holds: recorded, written, printed."""

from __future__ import annotations

from pathlib import Path

import pandas
import pytest

from tests.orchestration.simulated import called, simulate
from warmlink.orchestration.master.compiled.loop import Stepping
from warmlink.orchestration.master.error_budget import coupling_error
from warmlink.orchestration.master.recording.checkpoint import LongRun
from warmlink.orchestration.master.recording.recorder import values_in
from warmlink.orchestration.master.run import simulate as run
from warmlink.orchestration.report.recorded import columns_of
from warmlink.orchestration.system.model import FmuPart, System

from .hand_written import compiled

N, U, NEGATIVE = 9007199254740992, 2**64 - 1, -4503599627370490
SIGNED = """<Int64 name="n" valueReference="0" causality="output" initial="exact" start="9007199254740992"/>
<Int64 name="inside" valueReference="1" causality="local"/>"""
UNSIGNED = '<UInt64 name="u" valueReference="2" causality="output"/>'


def counter(folder: Path, variables: str) -> Path:
    references = (reference for reference in "02" if f'"{reference}"' in variables)
    outputs = "".join(f'<Output valueReference="{reference}"/>' for reference in references)
    return compiled(
        folder,
        Path(__file__).with_name("integers.c"),
        f'<fmiModelDescription fmiVersion="3.0" modelName="Integers" instantiationToken="x"><CoSimulation '
        f'modelIdentifier="Integers" canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{variables}</ModelVariables><ModelStructure>{outputs}</ModelStructure></fmiModelDescription>",
    )


@pytest.mark.parametrize("stepping", ["plain", "compiled"])
def test_they_are_recorded_as_they_are(stepping: Stepping, tmp_path: Path) -> None:
    """Patterns that are no number as a double, as those of integers below 0, pass the compiled loop, too."""
    counting = System("s", {"c": FmuPart("c", counter(tmp_path, SIGNED))})
    found = run(counting, 20.0, 1.0, record=["c.inside", "c.n"], stepping=stepping)
    assert found["c.n"].tolist() == [N + k for k in range(21)]
    assert found["c.inside"].tolist() == [NEGATIVE - k for k in range(21)]
    assert found.statistics.compiled == (stepping == "compiled")
    half = run(counting, 20.0, 0.5, record=["c.n"], stepping=stepping)
    assert coupling_error(found, half, 1, ["c.n"])["c.n"] == pytest.approx(3.0 * 20)


@pytest.fixture
def unsigned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return counter(tmp_path, SIGNED + UNSIGNED)


@pytest.mark.parametrize("more", [(), ("--isolate",)])
def test_files_and_the_answer_hold_them(
    unsigned: Path, more: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--stop", "1 s", "--step", "1 s", "--out", "o")
    answer, _ = simulate(unsigned, *options, *more, capsys=capsys)
    outputs = answer["outputs"]
    assert {key: outputs["Integers.n"][key] for key in ("last", "min", "max")} == {
        "last": N + 1,
        "min": N,
        "max": N + 1,
    }
    assert outputs["Integers.u"]["last"] == U - 1
    heading = "Integers.u [1]"
    for read in (pandas.read_csv("o/results.csv"), pandas.read_parquet("o/results.parquet")):
        assert read[heading].tolist() == [U, U - 1]
        assert read["Integers.n [1]"].tolist() == [N, N + 1]
    assert columns_of("o")["Integers.n [1]"][1] == float(N + 1)


def test_values_that_are_streamed_to_disk_hold_them(unsigned: Path, tmp_path: Path) -> None:
    counting = System("s", {"c": FmuPart("c", unsigned)})
    run(counting, 2.0, 1.0, long_run=LongRun(tmp_path / "o", every=None))
    kept = values_in(tmp_path / "o")
    assert kept is not None
    assert kept["c.u"].tolist() == [U, U - 1, U - 2]
    assert kept.to_frame()["c.n [1]"].tolist() == [N, N + 1, N + 2]


def test_the_table_shows_them(unsigned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called(unsigned, "--stop", "1 s", "--step", "1 s", "--out", "o") == 0
    assert str(N + 1) in capsys.readouterr().out
