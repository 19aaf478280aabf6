"""What the cache hands out is what was put there: damaged files are made anew, strangers' not read."""

from __future__ import annotations

import compileall
import hashlib
import os
import pickle
import tempfile
from pathlib import Path
from typing import Any

import pytest

from tests.filled import cell_fmus, fill
from warmlink.fmus.packaging import trust
from warmlink.fmus.packaging.cache import (
    CACHE_VARIABLE,
    cache_folder,
    kept,
    remembered,
    source_digest,
    undamaged,
)
from warmlink.orchestration.catalogue import controller_named
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.outcome import run
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.system.archive import unpack

POSIX = pytest.mark.skipif(os.name != "posix", reason="rights are those of POSIX")


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path / "cache"


def flip(file: Path, place: int) -> bytes:
    """Flip a bit, keep size and time of the file, and give what it held before."""
    before, facts = file.read_bytes(), file.stat()
    place %= len(before)
    file.write_bytes(before[:place] + bytes([before[place] ^ 4]) + before[place + 1 :])
    os.utime(file, ns=(facts.st_atime_ns, facts.st_mtime_ns))
    return before


@pytest.mark.parametrize("place", [0, 1 << 10, -30])
def test_a_flipped_bit_of_a_cached_fmu(cache: Path, place: int) -> None:
    held = FmuStore("python").files(["Heater"])["Heater"]
    before = flip(held, place)
    assert FmuStore("python").files(["Heater"])["Heater"].read_bytes() == before


def test_a_flipped_bit_of_what_an_fmu_was_unpacked_to(cache: Path) -> None:
    held = FmuStore("python").files(["Heater"])["Heater"]
    folder = unpack(held, cache / "unpacked")
    files = [path for path in folder.rglob("*") if path.is_file() and path.stat().st_size]
    assert len(files) > 5
    before = {path: flip(path, 100) for path in files}
    files[0].unlink()
    (folder / "written by the FMU").write_text("stays")
    assert unpack(held, cache / "unpacked") == folder
    assert {path: path.read_bytes() for path in files} == before
    assert (folder / "written by the FMU").is_file()


def test_byte_code_is_made_anew_since_nothing_tells_whether_it_is_whole(cache: Path) -> None:
    held = FmuStore("python").files(["Heater"])["Heater"]
    folder = unpack(held, cache / "unpacked")
    compileall.compile_dir(folder, quiet=2)
    assert [*folder.rglob("*.pyc")]
    unpack(held, cache / "unpacked")
    assert not [*folder.rglob("*.pyc")]


@pytest.fixture(scope="module")
def compiled() -> dict[str, Path]:
    """FMUs of the tests' cache: found before `cache` names another one."""
    return cell_fmus("lag")


def test_a_flipped_bit_of_a_library_does_not_change_a_run(compiled: dict[str, Path], cache: Path) -> None:
    def largest() -> tuple[float, float]:
        found = run("windshield_wiper", "lag", stop="1 min", step="5 s", fmus="native")
        return found.metrics.max_abs_um, found.uncompensated.max_abs_um

    fill(cache, compiled)
    before = largest()
    (library,) = (cache / source_digest() / "native" / "unpacked").glob("ThermalLink-*/binaries/*/*")
    held = library.read_bytes()
    for place in range(0x1000, len(held), len(held) // 3):
        flip(library, place)
        assert largest() == before
        assert library.read_bytes() == held


def test_an_own_laws_damaged_fmu_is_built_anew(cache: Path, tmp_path: Path) -> None:
    law = tmp_path / "own.py"
    law.write_text(
        "from warmlink.controllers.own import Law\n\n\nclass Mine(Law):\n"
        "    def correction(self, x, u, p, time):\n        return 1e-6\n"
    )
    mine = controller_named(f"{law}:Mine")
    (held,) = FmuStore("python").of_controller(mine).values()
    before = flip(held, 500)
    assert FmuStore("python").of_controller(mine)["Mine"].read_bytes() == before


class Planted:
    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(Path(os.environ[CACHE_VARIABLE]).with_name("code ran")),)


@POSIX
@pytest.mark.parametrize("rights", [0o777, 0o1777, 0o702, 0o722])
def test_nothing_is_read_from_a_folder_that_others_may_write_to(
    cache: Path, tmp_path: Path, rights: int
) -> None:
    place = {"things": 1}
    remembered("facts", place, lambda: "made first")
    (file,) = cache.glob("facts/*.kept")
    content = pickle.dumps(Planted())
    file.write_bytes(hashlib.sha256(content).digest() + content)
    cache.chmod(rights)
    assert remembered("facts", place, lambda: "made anew") == "made anew"
    assert not (tmp_path / "code ran").exists()
    assert not cache_folder().is_relative_to(cache)
    assert cache_folder().stat().st_mode & 0o077 == 0
    said: list[str] = []
    assert not store("python", [], said.append).folder.is_relative_to(cache)
    assert "others may write to it" in said[0]
    assert CACHE_VARIABLE in said[0]


@POSIX
def test_nor_from_a_folder_below_one(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with tempfile.TemporaryDirectory(dir="/tmp") as above:  # where others come, unlike to a test's own folder
        monkeypatch.setenv(CACHE_VARIABLE, f"{above}/cache")
        Path(above).chmod(0o755)
        kept("below one", 1, lambda: b"first")
        assert kept("below one", 1, lambda: b"again") == b"first"
        Path(above).chmod(0o777)
        trust._found.cache_clear()  # another process looks anew
        assert not cache_folder().is_relative_to(above)
        assert kept("below one", 1, lambda: b"again") == b"again"


@POSIX
@pytest.mark.parametrize("rights", [0o700, 0o755, 0o750])
def test_a_folder_that_others_may_read_is_used(cache: Path, rights: int) -> None:
    kept("things", 1, lambda: b"first")
    cache.chmod(rights)
    assert kept("things", 1, lambda: b"again") == b"first"
    assert cache_folder() == cache


@POSIX
def test_a_new_cache_is_its_owners(cache: Path) -> None:
    before = os.umask(0)
    try:
        assert cache_folder().stat().st_mode & 0o077 == 0
    finally:
        os.umask(before)


def test_a_damaged_table_is_read_from_the_scenario_again(cache: Path) -> None:
    before = load_scenario("warm_up")
    files = [*cache.rglob("*.kept")]
    assert files
    held = {file: flip(file, -10) for file in files}
    assert load_scenario("warm_up") == before
    assert {file: file.read_bytes() for file in files} == held


@POSIX
def test_folders_of_a_cache_that_others_cannot_enter_are_out_of_their_reach(cache: Path) -> None:
    before = os.umask(0)
    try:
        kept("things", 1, lambda: b"first")
        FmuStore("python").files(["Heater"])
    finally:
        os.umask(before)
    assert kept("things", 1, lambda: b"again") == b"first"
    assert undamaged(FmuStore("python").folder / "Heater.fmu")
