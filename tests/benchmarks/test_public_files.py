"""What the benchmark on other people's files makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.public_files import BAD, Ran, judged, seen
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
