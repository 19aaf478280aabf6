"""Whatever is done to a file, it is taken or refused in one sentence, and nothing is written elsewhere."""

from __future__ import annotations

import mmap
import os
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis import given as drawn
from hypothesis import strategies as st

from benchmarks.fuzz import mutate, worker
from benchmarks.fuzz.nest import emptied, nest, strays
from benchmarks.fuzz.targets import TARGETS, Target
from benchmarks.fuzz.worker import findings, given
from warmlink.fmus.errors import InputError, SeveralError, refusal
from warmlink.orchestration.master.slaves.slave import SlaveError

SEED = int(os.environ.get("WARMLINK_FUZZ_SEED", "1"))
EXAMPLES = int(os.environ.get("WARMLINK_FUZZ_EXAMPLES", "30"))


@pytest.fixture(scope="module", autouse=True)
def _fmus() -> None:
    try:
        for target in TARGETS.values():
            target.files()
    except InputError as fault:
        pytest.skip(str(fault))


@pytest.fixture
def home() -> Iterator[Path]:
    with nest() as folder:
        yield folder


@pytest.mark.parametrize("name", TARGETS)
def test_the_good_files_are_taken(name: str, home: Path) -> None:
    target, folder = TARGETS[name], emptied(home)
    for other, content in target.files().items():
        (folder / other).write_bytes(content)
    for damaged in target.damaged or target.files():
        assert target.judged(folder / damaged) == "accepted"
    assert strays(home) == []


@pytest.mark.parametrize("name", TARGETS)
def test_damaged_files_are_taken_or_refused(name: str, home: Path) -> None:
    print(f"WARMLINK_FUZZ_SEED={SEED}")
    target = TARGETS[name]

    @seed(SEED)
    @settings(
        max_examples=max(2, round(EXAMPLES * target.share)),
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    @drawn(st.randoms(use_true_random=False))
    def tried(random: Random) -> None:
        path = target.written(random, emptied(home))
        assert target.judged(path) in ("accepted", "refused")
        assert strays(home) == []

    tried()


def test_the_same_seed_gives_the_same_inputs(tmp_path: Path) -> None:
    texts = [
        given("duty", number, other, tmp_path).read_bytes()
        for number, other in ((3, 5), (3, 5), (3, 6), (4, 5))
    ]
    assert texts[0] == texts[1]
    assert len(set(texts)) == 3


def test_quotes_words_and_units_get_into_files_and_pieces_into_others() -> None:
    table = TARGETS["measured"].files()["measured.csv"]
    for name in ("quoted", "words", "word_columns", "huge_units"):
        damaged = [getattr(mutate, name)(Random(number), table) for number in range(20)]
        assert all(each != table for each in damaged), name
        assert len(set(damaged)) > 10, name
    assert all(
        each.count(b'"') > table.count(b'"') for each in (mutate.quoted(Random(i), table) for i in range(9))
    )
    assert all(len(mutate.huge_units(Random(i), table)) > 4000 for i in range(9))
    other = b"".join(b"a piece of another file, line %d\n" % i for i in range(40))
    swapped = mutate.swapping(lambda: {"other": other})
    assert sum(b"another file" in swapped(Random(i), table) for i in range(20)) > 10


def test_what_is_wrong_is_told_from_what_is_right(tmp_path: Path) -> None:
    def judged(fault: Exception | None) -> str:
        def use(path: Path) -> None:
            if fault is not None:
                raise fault

        return replace(TARGETS["duty"], use=use).judged(tmp_path)

    assert judged(None) == "accepted"
    assert judged(InputError("duty.csv: is empty; give a header")) == "refused"
    assert judged(KeyError("time")).startswith("KeyError")
    # An InputError is one line whatever it is made of.
    assert judged(SlaveError("link", "error", 0.0, "two\nlines of it")).startswith("not one line")
    assert judged(InputError("no")).startswith("2 characters")
    assert judged(refusal(f"scenario: entry {i} is missing" for i in range(30))) == "refused"
    assert judged(refusal(["scenario: stop_time is missing", "no"])).startswith("2 characters")
    assert judged(SeveralError(*["scenario: stop_time is missing"] * 30)).startswith("30 lines")


def test_workers_try_every_input_and_keep_those_that_fail(tmp_path: Path) -> None:
    found = list(findings("mismatch", 1, range(4), tmp_path))
    assert [each.number for each in found] == [0, 1, 2, 3]
    assert {each.verdict for each in found} <= {"accepted", "refused"}
    assert list(tmp_path.iterdir()) == []


MEGABYTES = 512
RESERVED: list[mmap.mmap] = []


def take_memory(path: Path) -> None:
    """Take more addresses than it may use memory; where the file says so, use them too, and say nothing."""
    RESERVED.append(mmap.mmap(-1, 600_000_000))
    if path.read_text() == "greedy":
        assert len(b"x" * 600_000_000) == 600_000_000


MEMORY = Target(
    lambda: {"memory": b""}, (lambda random, content: random.choice((b"greedy", b"modest")),), take_memory
)


def work_with_memory(pipe: Connection, name: str, seed: int, numbers: range) -> None:
    TARGETS[name] = MEMORY
    worker.MOST_MEGABYTES = MEGABYTES
    worker._work(pipe, name, seed, numbers)


@pytest.mark.slow
def test_memory_is_counted_where_it_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TARGETS, "memory", MEMORY)
    monkeypatch.setattr(worker, "_work", work_with_memory)
    monkeypatch.setattr(worker, "MOST_MEGABYTES", MEGABYTES)
    found = [each.verdict for each in findings("memory", 8, range(3), tmp_path)]
    assert found == ["accepted", f"uses more than {MEGABYTES} MB of memory", "accepted"]
    assert [(path.name, (path / "memory").read_text()) for path in tmp_path.iterdir()] == [
        ("memory-1", "greedy")
    ]
