"""Mutants change what runs and nothing else, and a copy of the project tells which no test notices."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import mutations
from benchmarks.mutants import mutants
from benchmarks.mutations import HUNG, KILLED, SURVIVED, Change, Copy, sample
from warmlink.fmus.errors import InputError

SOURCE = '''"""Text."""

def larger(a: int = 0, b: "list[1]" = ()) -> int:
    """Say 2."""
    if a:
        a += 1
    return a - 1 if a < 3 and b is None else f"{a + 2}"
    c = zip(b, b, strict=True)
'''


def test_each_kind_of_change_is_made_once_where_it_stands() -> None:
    found = [(each.line, each.before, each.after) for each in mutants(SOURCE)]
    assert found == [
        (3, "0", "1"),
        (5, "a", "(not a)"),
        (6, "a += 1", "pass"),
        (6, "1", "2"),
        (7, 'return a - 1 if a < 3 and b is None else f"{a + 2}"', "return None"),
        (7, "a < 3 and b is None", "(a < 3 or b is None)"),
        (7, "a < 3", "(a >= 3)"),
        (7, "3", "4"),
        (7, "b is None", "(b is not None)"),
        (7, "a - 1", "(a + 1)"),
        (7, "1", "2"),
    ]
    for each in mutants(SOURCE):
        compile(each.source, "larger.py", "exec")


def test_letters_of_more_bytes_shift_nothing() -> None:
    (only,) = mutants('µ = "µ", 1\n')
    assert only.source == 'µ = "µ", 2\n'


def test_a_sample_is_that_of_its_seed() -> None:
    first, again, other = (sample("closed_loop", 5, seed) for seed in (1, 1, 2))
    assert first == again != other
    assert all(each.path.parts[:2] == ("orchestration", "closed_loop") for each in first)


@pytest.fixture
def copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Copy:
    """A copy of a project with one room of one module, and a test of it."""
    root = tmp_path / "project"
    for name, text in (
        ("fmus/double.py", "def double(a):\n    while a < 0:\n        a += 9\n    return a * 2 + 0\n"),
        (
            "tests/fmus/test_double.py",
            "import double\n\n\ndef test_it():\n    assert double.double(-9) == 0\n",
        ),
        ("pyproject.toml", ""),
    ):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, "utf-8")
    monkeypatch.setattr(mutations, "ROOT", root)
    monkeypatch.setattr(mutations, "COPIED", ("fmus", "tests"))
    monkeypatch.setattr(mutations, "FILES", ("pyproject.toml",))
    monkeypatch.setattr(mutations, "PATH", "fmus")
    return Copy(tmp_path / "scratch")


@pytest.mark.slow
def test_what_no_test_notices_survives(copy: Copy, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path("fmus/double.py")
    text = (copy.home / path).read_text("utf-8")
    found = {(each.before, each.after): each for each in mutants(text)}
    ends = {
        ("a < 0", "(a >= 0)"): KILLED,
        ("2", "3"): SURVIVED,
    }
    assert {key: copy.outcome(Change(path, found[key])) for key in ends} == ends
    assert (copy.home / path).read_text("utf-8") == text
    monkeypatch.setattr(mutations, "LEAST_S", 0.0)
    monkeypatch.setattr(mutations, "PATIENCE", 0.01)
    assert copy.outcome(Change(path, found["2", "3"])) == HUNG


@pytest.mark.slow
def test_tests_that_fail_as_the_code_is_are_refused(copy: Copy) -> None:
    path = Path("fmus/double.py")
    (copy.home / "tests/fmus/test_double.py").write_text("def test_it():\n    assert False\n", "utf-8")
    with pytest.raises(InputError, match=r"tests/fmus/test_double\.py: fail before anything is changed"):
        copy.outcome(Change(path, mutants("a = 1\n")[0]))
