"""Object files are compiled once and kept for builds to come."""

import os
import shutil
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging import cache
from warmlink.fmus.packaging.cache import CACHE_VARIABLE, kept, kept_before, remembered
from warmlink.fmus.packaging.native import compile as compiling
from warmlink.fmus.packaging.native import library
from warmlink.fmus.packaging.native.compile import Compiler, host_platform
from warmlink.orchestration.master.compiled import loop

SOURCES = {
    "one.c": "int one(void) { return 1; }\n",
    "two.c": '#include "two.h"\nint two(void) { return TWO; }\n',
}
HEADER = {"two.h": "#define TWO 2\n"}

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler on this machine")


@pytest.fixture
def compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Compiler:
    """This machine's, which notes what it is asked for."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    script = tmp_path / "noting"
    script.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path / "asked"}\nexec cc "$@"\n')
    script.chmod(0o755)
    platform = host_platform()
    assert platform is not None
    return Compiler((str(script),), platform)


def compiled(compiler: Compiler, sources: dict[str, str], tmp_path: Path) -> list[str]:
    """Units that a new process compiles to build a library."""
    compiling._object.cache_clear()
    (tmp_path / "asked").write_text("")
    assert compiler.library(sources, "numbers")
    asked = (tmp_path / "asked").read_text().splitlines()
    return sorted(line.split("-c ")[1].split()[0] for line in asked if " -c " in line)


def test_what_is_the_same_is_compiled_once(compiler: Compiler, tmp_path: Path) -> None:
    assert compiled(compiler, SOURCES | HEADER, tmp_path) == ["one.c", "two.c"]
    assert compiled(compiler, SOURCES | HEADER, tmp_path) == []
    assert compiled(compiler, SOURCES | {"two.h": "#define TWO 3\n"}, tmp_path) == ["two.c"]
    other = Compiler(compiler.command, compiler.platform, (*compiler.flags, "-O0"))
    assert compiled(other, SOURCES | HEADER, tmp_path) == ["one.c", "two.c"]


def test_a_cache_that_cannot_be_written_costs_time_alone(
    compiler: Compiler, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file" / "cache"))
    assert compiled(compiler, SOURCES | HEADER, tmp_path) == ["one.c", "two.c"]


def test_of_two_that_want_the_same_at_once_one_makes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    both, made = threading.Barrier(2), []

    def make() -> bytes:
        made.append(1)
        with suppress(threading.BrokenBarrierError):
            both.wait(0.2)  # for the other, were it allowed in
        return b"made"

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda _: kept("things", "the same", make), range(2))) == [b"made"] * 2
    assert made == [1]


def test_what_is_damaged_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    assert kept("things", "the same", lambda: b"made") == b"made"
    (file,) = (tmp_path / "things").glob("*.kept")
    whole = file.read_bytes()
    file.write_bytes(whole[:-1])
    assert kept("things", "the same", lambda: b"made") == b"made"
    assert file.read_bytes() == whole


def test_of_much_what_was_not_used_for_longest_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setenv(cache.LIMIT_VARIABLE, "1")
    build, *studies = (f"{n:016x}" for n in range(5))
    old, older, use, new = (f"studies/{each}" for each in studies)
    theirs = ("photos/holiday", "unpacked/letters", f"work/{'a' * 15}")
    ages = {old: 9, f"{build}/native": 8, older: 10, use: 5, new: 0, "unpacked/4711": 20}
    ages |= dict.fromkeys(theirs, 99)
    for name, days in ages.items():
        folder = tmp_path / name
        folder.mkdir(parents=True)
        (folder / "file").write_bytes(bytes(400_000))
        for path in (folder / "file", folder):
            os.utime(path, (time.time() - days * 86400,) * 2)
    (tmp_path / "studies" / f"{5:016x}").mkdir()  # as one has it that nothing was unpacked into
    kept("things", "the next", lambda: bytes(400_000))
    left = {path.parent.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("file")}
    assert left == {new, *theirs}, "what is used today stays, however much it is, and what is not the cache's"
    assert kept_before("things", "the next") is not None


def test_two_processes_make_room_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setenv(cache.LIMIT_VARIABLE, "0")
    (tmp_path / "unpacked").mkdir()
    for name in ("1", "2"):
        (tmp_path / "unpacked" / name).write_bytes(b"file")
        os.utime(tmp_path / "unpacked" / name, (0, 0))
    look = cache._last_used

    def looked(entry: Path) -> tuple[float, int, Path]:
        if entry.name == "2":
            entry.unlink()  # by the other process
        return look(entry)

    monkeypatch.setattr(cache, "_last_used", looked)
    cache.make_room()
    assert not [*(tmp_path / "unpacked").iterdir()]


def test_a_cache_that_has_room_is_not_looked_through_by_every_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setenv(cache.LIMIT_VARIABLE, "1")
    old = tmp_path / "unpacked" / "1"
    old.parent.mkdir()
    for limit, minutes, looked in (("1", 0, True), ("1", 0, False), ("0.5", 0, True), ("0.5", 61, True)):
        old.write_bytes(bytes(2_000_000))
        os.utime(old, (0, 0))
        monkeypatch.setenv(cache.LIMIT_VARIABLE, limit)
        with suppress(FileNotFoundError):
            os.utime(tmp_path / "room", (time.time() - 60 * minutes,) * 2)
        cache.make_room()
        assert old.exists() != looked


def test_an_empty_folder_of_the_cache_is_no_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setenv(cache.LIMIT_VARIABLE, "0")
    (tmp_path / "unpacked" / "1").mkdir(parents=True)
    os.utime(tmp_path / "unpacked" / "1", (0, 0))
    cache.make_room()
    assert not (tmp_path / "unpacked" / "1").exists()


def test_what_is_read_counts_as_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    kept("things", "the same", lambda: b"made")
    (file,) = (tmp_path / "things").glob("*.kept")
    os.utime(file, (0, 0))
    kept("things", "the same", lambda: b"made")
    assert file.stat().st_mtime > time.time() - 60


def test_where_nothing_can_be_kept_it_is_made_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> Path:
        raise InputError("there is no folder for it")

    monkeypatch.setattr(cache, "cache_folder", none)
    assert kept("things", "the same", lambda: b"made") == b"made"


@pytest.mark.parametrize("limit", ["much", "-1", "nan"])
def test_a_limit_that_is_none_is_refused(limit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setenv(cache.LIMIT_VARIABLE, limit)
    with pytest.raises(InputError, match=f"{cache.LIMIT_VARIABLE} is '{limit}'"):
        kept("things", "the same", lambda: b"made")


def test_a_library_is_kept_for_its_compiler_and_flags(monkeypatch: pytest.MonkeyPatch) -> None:
    keys: list[object] = []

    def noted(folder: str, made_from: object, make: object) -> bytes:
        keys.append(made_from)
        raise InputError("enough")

    monkeypatch.setattr(loop, "kept", noted)
    for change in (lambda: None, lambda: monkeypatch.setenv("CC", "other")):
        change()
        with pytest.raises(InputError, match="enough"):
            loop.library.__wrapped__()
    monkeypatch.setattr(library, "FLAGS", ("-O0",))
    with pytest.raises(InputError, match="enough"):
        loop.library.__wrapped__()
    assert len({repr(key) for key in keys}) == 3


def test_what_is_remembered_is_made_once_for_each_state_of_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    made: list[int] = []

    def found() -> list[int]:
        return remembered("things", "the same", lambda: made.append(1) or [len(made)])

    assert [found(), found()] == [[1], [1]]
    monkeypatch.setattr(cache, "source_state", lambda: "another")
    assert [found(), found()] == [[2], [2]]
    for file in (tmp_path / "things").iterdir():
        file.write_bytes(b"damaged")
    assert [found(), found()] == [[3], [3]]


def test_what_python_writes_beside_the_source_is_none_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for room in ("fmus", "controllers", "orchestration"):
        (tmp_path / room).mkdir()
    monkeypatch.setattr(cache, "ROOMS", tmp_path)
    finders = cache.source_state.__wrapped__, cache._source_digest.__wrapped__
    before = [find() for find in finders]
    # The name under which a module's byte code is written before it is whole.
    (tmp_path / "fmus" / "__pycache__").mkdir()
    (tmp_path / "fmus" / "__pycache__" / "names.cpython-312.pyc.140234").touch()
    assert [find() for find in finders] == before
    (tmp_path / "fmus" / "names.py").touch()
    assert all(find() != old for find, old in zip(finders, before, strict=True))


def test_refused_files_are_not_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))

    def refuse() -> str:
        raise InputError("mend it")

    for _ in range(2):
        with pytest.raises(InputError, match="mend it"):
            remembered("things", "the same", refuse)
    assert not list(tmp_path.rglob("*.*"))


def test_what_cannot_be_remembered_is_made_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    assert remembered("things", 16**5000, lambda: "of a number that no text tells") == (
        "of a number that no text tells"
    )
    unlocked = threading.Lock()  # cannot be pickled
    assert remembered("things", "the same", lambda: unlocked) is unlocked
    assert not list(tmp_path.rglob(".writing-*"))
