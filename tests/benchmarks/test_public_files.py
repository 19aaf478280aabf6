"""What the benchmark on other people's files makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.public_files import BAD, Ran, Seen, judged, seen
from benchmarks.public_page import files_section
from benchmarks.trivial_fmu import build_trivial_fmu
from warmlink.fmus.errors import InputError


@pytest.mark.parametrize(
    ("own", "reference", "outcome"),
    [
        (Ran({"y": [1.0, 2.0]}, ""), Ran({"y": [1.0, 2.0 + 1e-7]}, ""), "same numbers"),
        (Ran({"y": [1.0, 2.0]}, "warmlink: a remark"), Ran({"y": [1.0, 2.1]}, ""), "differs, with a word"),
        (Ran({"y": [1.0, 2.0]}, ""), Ran({"y": [1.0, 2.1]}, ""), "DIFFERS WITHOUT A WORD"),
        (Ran({"y": [1.0]}, ""), Ran({"y": [1.0, 2.0]}, ""), "DIFFERS WITHOUT A WORD"),
        (Ran({"y": [float("nan")]}, ""), Ran({"y": [1.0]}, ""), "DIFFERS WITHOUT A WORD"),
        (Ran({"y": [1.0]}, ""), Ran(None, "no"), "runs here alone"),
        (Ran(None, "warmlink: no"), Ran({"y": [1.0]}, ""), "refused with a sentence"),
        (Ran(None, "warmlink: no"), Ran(None, "no"), "refused by both"),
        (Ran(None, "Traceback"), Ran(None, "no"), "REFUSED WITHOUT A SENTENCE"),
        (Ran(None, ""), Ran({"y": [1.0]}, ""), "REFUSED WITHOUT A SENTENCE"),
    ],
)
def test_outcomes(own: Ran, reference: Ran, outcome: str) -> None:
    assert judged(Path("x.fmu"), own, reference).outcome == outcome
    assert (outcome in BAD) == outcome.isupper()


def test_a_solver_inside_may_differ_by_its_tolerance() -> None:
    own, reference = Ran({"y": [1.0, 2.0]}, ""), Ran({"y": [1.0, 2.0001]}, "")
    assert judged(Path("x.fmu"), own, reference, 1e-4).outcome == "same to the FMU's tolerance"
    assert judged(Path("x.fmu"), own, reference, 1e-5).outcome == "DIFFERS WITHOUT A WORD"


def test_a_folder_of_files_is_run_by_both(tmp_path: Path) -> None:
    try:
        build_trivial_fmu(tmp_path)
    except InputError as fault:
        pytest.skip(str(fault))
    (tmp_path / "no.fmu").write_bytes(b"no archive")
    assert {each.file.name: each.outcome for each in seen([tmp_path])} == {
        "Trivial2.fmu": "same numbers",
        "no.fmu": "refused by both",
    }
    with pytest.raises(InputError, match="no such folder"):
        list(seen([tmp_path / "absent"]))


def test_the_page_counts_and_says_why(tmp_path: Path) -> None:
    """Counts by outcome and kind, reasons of refusals, and each file that is not simply equal."""
    kind, away = (
        "FMI 1.0 co-simulation",
        "warmlink: fmu: Wall.fmu holds no library for linux64 (it has: win64)",
    )
    found = [
        Seen(tmp_path / "a/Mass.fmu", "same numbers", "", 2e-16, kind),
        Seen(tmp_path / "b/Wall.fmu", "refused by both", away),
        Seen(tmp_path / "b/Tank.fmu", "same to the FMU's tolerance", "h by 3e-05; ", 3e-5, kind),
    ]
    text = "\n".join(files_section(found, tmp_path))
    assert "| the same numbers | 1 |" in text
    assert f"| {kind} | 2 of 2 | 1 | 2e-16 |" in text
    assert "| no library for this platform inside | 1 |" in text
    assert "| b/Tank.fmu | the same to the FMU's tolerance | h by 3e-05; |" in text
    assert "a/Mass.fmu" not in text
