"""The table of what ran where: its words, and OMSimulator where it is installed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from benchmarks.compatibility import OUTSIDE, Seen, agreement, page, seen
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.system.write import write_ssp


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (2.0, "equal to the last bit"),
        (2.0 + 1e-9, "agrees to 9 digits"),
        (2.1, "agrees to 1 digits"),
        (-7.0, "agrees to 0 digits"),
        (float("nan"), "nan where ours is 2"),
    ],
)
def test_agreement_is_told_in_digits(value: float, words: str) -> None:
    assert agreement(value, 2.0) == words


def test_the_page_holds_date_versions_and_what_ran() -> None:
    text = page([Seen("Ecos", "WarmupCell.ssp", "`init()`", "equal to the last bit")])
    assert "| Ecos | WarmupCell.ssp | `init()` | equal to the last bit |" in text
    assert "FMPy 0." in text
    assert all(package in text for package in OUTSIDE)


def test_a_folder_without_a_build_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no WarmupCell\.ssp; run warmlink build --out"):
        next(seen(tmp_path))


@pytest.mark.platform
@pytest.mark.skipif(shutil.which("OMSimulator") is None, reason="OMSimulator is not installed")
def test_omsimulator_runs_the_cell(tmp_path: Path) -> None:
    law = controller("lag").name
    files = FmuStore("native").files(WARMUP_CELL.parts_with(law).values())
    write_ssp(WARMUP_CELL.system(files, law), tmp_path / "WarmupCell.ssp")
    command = ["OMSimulator", str(tmp_path / "WarmupCell.ssp"), "--stopTime=10"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]
