"""What the site's blocks gave is kept, and runs again only if something before it has changed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.documented import kept


def built(tmp_path: Path, texts: list[str], code: str = "code") -> tuple[list[str], list[str]]:
    """Build a page of blocks that each read what the ones before wrote; what ran, and what is shown."""
    ran: list[str] = []
    page = kept.Page(tmp_path / "page", tmp_path / "kept", key=code)
    page.before_the_next("file", lambda: (page.folder / "file").write_text("file"))

    def block(text: str) -> kept.Content:
        ran.append(text)
        file = page.folder / "file"
        file.write_text(f"{file.read_text()} {text}")
        return {"printed": file.read_text(), "failed": "fails" in text}

    shown = [page.result(text, "page:1", lambda text=text: block(text))["printed"] for text in texts]
    return ran, shown


def test_nothing_runs_again_while_nothing_changes(tmp_path: Path) -> None:
    first = built(tmp_path, ["a", "b", "c"])
    assert first == (["a", "b", "c"], ["file a", "file a b", "file a b c"])
    assert built(tmp_path, ["a", "b", "c"]) == ([], first[1])


def test_a_changed_block_runs_after_those_before_it(tmp_path: Path) -> None:
    built(tmp_path, ["a", "b", "c"])
    ran, shown = built(tmp_path, ["a", "b", "other"])
    assert (ran, shown[-1]) == (["a", "b", "other"], "file a b other")
    assert built(tmp_path, ["x", "b", "c"])[0] == ["x", "b", "c"]


def test_other_code_runs_all_of_it(tmp_path: Path) -> None:
    built(tmp_path, ["a", "b"])
    assert built(tmp_path, ["a", "b"], "other code")[0] == ["a", "b"]


def test_what_failed_is_tried_again(tmp_path: Path) -> None:
    built(tmp_path, ["a", "fails"])
    assert built(tmp_path, ["a", "fails"])[0] == ["a", "fails"]


def test_what_no_page_uses_any_more_goes(tmp_path: Path) -> None:
    built(tmp_path, ["a", "b"])
    for path in (tmp_path / "kept").iterdir():
        os.utime(path, (0, 0))
    built(tmp_path, ["a"])
    kept.forget(tmp_path / "kept", since=1.0)
    assert len([*(tmp_path / "kept").iterdir()]) == 1


def test_progress_says_which_pages_are_left(capsys: pytest.CaptureFixture[str]) -> None:
    progress = kept.Progress.over(["control", "data"])
    progress.read("generated/names")
    progress.read("data")
    progress.read("control")
    lines = capsys.readouterr().err.splitlines()
    assert [line.partition(" after ")[0] for line in lines] == ["1 of 2 pages", "2 of 2 pages"]
    assert lines[0].endswith("data; left: control")
    assert lines[1].endswith("  control")
