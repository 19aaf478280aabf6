"""What an FMU may have changed of this process is put back, and told."""

from __future__ import annotations

import locale
import platform
import sys
from pathlib import Path

import pytest

from warmlink.orchestration.master.slaves.surroundings import Surroundings, c_library

UPWARD = {"x86_64": 0x800, "aarch64": 0x400000, "arm64": 0x400000}


@pytest.mark.platform
def test_how_numbers_are_rounded_is_put_back() -> None:
    upward = UPWARD.get(platform.machine())
    if upward is None or sys.platform not in ("linux", "darwin"):
        pytest.skip("how to round upward is not known here")
    before, c = Surroundings(), c_library()
    nearest = c.fegetround()
    try:
        assert c.fesetround(upward) == 0
        assert before.put_back() == ("how numbers are rounded",)
        assert c.fegetround() == nearest
    finally:
        c.fesetround(nearest)
    assert before.put_back() == ()


def test_the_folder_and_the_locale_are_put_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    before, was = Surroundings(), locale.setlocale(locale.LC_ALL)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    other = "C" if was != "C" else "C.UTF-8"
    try:
        locale.setlocale(locale.LC_ALL, other)
    except locale.Error:
        pytest.skip("there is no other locale here")
    assert before.put_back() == ("the locale", "the working folder")
    assert Path.cwd() == tmp_path
    assert locale.setlocale(locale.LC_ALL) == was
