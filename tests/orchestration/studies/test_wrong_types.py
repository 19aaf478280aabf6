"""Every entry of a study, a mismatch and a duty cycle file with every wrong type, and nonsense for a file."""

import datetime
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.fuzz.mutate import changed, entry_at, ways_into
from benchmarks.fuzz.targets import SPECIMENS
from warmlink.fmus.errors import InputError
from warmlink.orchestration.closed_loop.load import load_scenario, of_tables, read_scenario
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import MOST_SEGMENTS
from warmlink.orchestration.scenarios.mismatch import Mismatch
from warmlink.orchestration.studies.study import load_study, read_study
from warmlink.orchestration.text_files import read_toml

STUDY, MISMATCH, DUTY, RANDOM, SCENARIO = (
    read_toml(SPECIMENS / f"{name}.toml") for name in ("study", "mismatch", "duty", "random", "scenario")
)
WRONG: list[Any] = [
    True,
    -3,
    10**320,
    2.5,
    float("nan"),
    float("inf"),
    "",
    "nonsense",
    "3 kg",
    "x" * 300,
    "a\0b",
    [],
    ["max_abs_um"],
    [["a"]],
    [{}],
    [None, 3],
    {},
    {"a": 1},
    {"min": []},
    datetime.date(2024, 1, 1),
    datetime.datetime(2024, 1, 1, tzinfo=datetime.UTC),
    datetime.time(3),
]


def study(given: dict[str, Any], folder: Path) -> None:
    read_study("mine", given, folder)


def mismatch(given: dict[str, Any], folder: Path) -> None:
    found: Mismatch = mismatches.parsed(given, "mine")
    load_scenario("windshield_wiper").mismatched(found).values()


def duty(given: dict[str, Any], folder: Path) -> None:
    found = duty_files.parsed(given, "mine")
    assert len(found.segments) <= MOST_SEGMENTS


def scenario(given: dict[str, Any], folder: Path) -> None:
    of_tables("mine", given).values()


FILES: dict[str, tuple[dict[str, Any], Callable[[dict[str, Any], Path], None]]] = {
    "study": (STUDY, study),
    "mismatch": (MISMATCH, mismatch),
    "duty": (DUTY, duty),
    "random": (RANDOM, duty),
    "scenario": (SCENARIO, scenario),
}


def fits(right: Any, value: Any) -> bool:
    """Whether a value is of a type that may stand for the right one."""
    if isinstance(right, bool) or isinstance(value, bool):
        return isinstance(right, bool) and isinstance(value, bool)
    if isinstance(right, str):
        quantity = right[0].isdigit() and isinstance(value, int | float)
        return quantity or isinstance(value, str)
    return isinstance(value, int | float if isinstance(right, int | float) else type(right))


def refusal(read: Callable[[dict[str, Any], Path], None], given: dict[str, Any], folder: Path) -> str | None:
    """The sentence with which tables are refused; None where they are taken."""
    try:
        read(given, folder)
    except InputError as fault:
        return str(fault)
    return None


@pytest.mark.parametrize("name", FILES)
def test_every_entry_with_every_wrong_type_ends_in_one_sentence(name: str, tmp_path: Path) -> None:
    table, read = FILES[name]
    assert refusal(read, table, tmp_path) is None
    for way in ways_into(table):
        right = entry_at(table, way)
        for value in WRONG:
            refused = refusal(read, changed(table, way, value), tmp_path)
            if refused is None:
                assert fits(right, value), (way, value)
                continue
            for sentence in refused.splitlines():  # one of each mistake
                assert len(sentence) > 20 or sentence.endswith(" more"), sentence
                assert len(sentence) < 1200, sentence


READERS: list[Callable[[str], object]] = [load_study, mismatches.load, load_scenario, duty_files.load]


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe\x00",
        b"title = 'caf\xe9'",
        b"a = " + 5000 * b"9",
        b"a = " + 100_000 * b"[",
        b"a = 1\na = 2",
        b"[a]\n[a]",
    ],
    ids=["empty", "utf-16", "latin-1", "digits", "deep", "twice", "table twice"],
)
def test_a_file_that_is_none_ends_in_one_sentence(
    read: Callable[[str], object], content: bytes, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_bytes(content)
    if read is mismatches.load and not content:
        return  # nothing differs
    with pytest.raises(InputError) as refusal:
        read(str(tmp_path / "mine.toml"))
    for sentence in str(refusal.value).splitlines():
        assert sentence.startswith("mine")
        assert len(sentence) < 600


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("name", ["x" * 300, "x" * 300 + ".toml", "a\0b.toml", ".", "/", ".toml"])
def test_a_name_that_is_no_files_is_refused(read: Callable[[str], object], name: str) -> None:
    with pytest.raises(InputError, match=r"no such|is a folder"):
        read(name)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {**RANDOM, "random": {**RANDOM["random"], "duration": ["0.1 s", "0.4 s"]}},
            "give bounds of at least 1 s",
        ),
        ({**RANDOM, "stop_time": "1e20 s"}, "100000 are the most"),
        (
            {**DUTY, "segment": [{**DUTY["segment"][0], "steps": 10**9}]},
            "1000000000 is not a whole number from 1 to 100000",
        ),
        ({**DUTY, "segment": [{"duration": 1}, {"duration": 1, "steps": 3}] * 50_001}, "100000 are the most"),
    ],
)
def test_an_endless_duty_cycle_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        duty_files.parsed(given, "mine")


def test_an_endless_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than a year"):
        scenario({**SCENARIO, "stop_time": "1e20 s"}, tmp_path)
    with pytest.raises(InputError, match="at most 1000000 in memory"):
        scenario({**SCENARIO, "step_size": "1e-9 s"}, tmp_path)
    with pytest.raises(InputError, match="at most 1000000 in memory"):
        study({**STUDY, "step_size": "1e-9 s"}, tmp_path)


def test_a_scenario_in_a_file_says_what_it_is(tmp_path: Path) -> None:
    assert read_scenario("mine", 'duty = "stop_and_go"').about
