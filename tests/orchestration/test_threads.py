"""BLAS works on one thread where it matters, and is given back as it was."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import warmlink as wl
from warmlink.orchestration import threads
from warmlink.orchestration.diagnosis import diagnose
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment


def counts() -> set[int]:
    return {threads._call(*each, "get")() for each in threads._libraries()}


class SearchedError(Exception):
    """Stands for a search."""


def test_where_blas_is_not_found_the_work_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "_USE_BLAS", ("scipy.linalg._moved",))
    with threads.one_thread():
        assert not counts()


@pytest.mark.skipif(sys.platform != "linux", reason="only there functions of a library's library are found")
def test_a_diagnosis_in_a_notebook_takes_one_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert counts() == {1}, "NumPy and SciPy bring OpenBLAS, which the tests let use one thread"
    seen = []

    def assess(*_: object) -> None:
        seen.append(counts())
        raise SearchedError

    monkeypatch.setattr(diagnose, "assess", assess)
    path = tmp_path / "run.csv"
    write_csv(hide({}, (Segment(1200, 2.0, 2.0),)), path)
    try:
        for each in threads._libraries():
            threads._call(*each, "set")(2)
        with pytest.raises(SearchedError):
            wl.diagnose(path)
        assert seen == [{1}]
        assert counts() == {2}
    finally:
        for each in threads._libraries():
            threads._call(*each, "set")(1)
