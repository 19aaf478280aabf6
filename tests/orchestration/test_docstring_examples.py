"""Each public function shows in its docstring how it is called, and that call exists."""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path

import pytest

import warmlink as wl

FUNCTIONS = sorted(name for name in wl.__all__ if inspect.isfunction(getattr(wl, name)))
OF_A_LAW = {"finite", "where", "join", "linearise"}
"""Functions that are used in equations, or on components of one's own, as the examples show."""

QUICK = ("describe", "design", "run", "plot", "assemble")
"""Functions whose examples need no file and take a moment, where the FMUs are built."""


def example(name: str) -> str:
    """Code of the example in a function's docstring."""
    lines = re.findall(r"^>>> (.*)$", inspect.getdoc(getattr(wl, name)) or "", re.MULTILINE)
    return "\n".join(lines)


def test_every_public_function_has_one() -> None:
    assert {name for name in FUNCTIONS if f"wl.{name}(" not in example(name)} == OF_A_LAW


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name not in OF_A_LAW])
def test_what_it_calls_takes_such_arguments(name: str) -> None:
    for call in ast.walk(ast.parse(example(name))):
        if isinstance(call, ast.Call) and re.fullmatch(r"wl\.\w+", called := ast.unparse(call.func)):
            named = {str(each.arg): each.value for each in call.keywords}
            inspect.signature(getattr(wl, called[3:])).bind(*call.args, **named)


@pytest.mark.parametrize("name", QUICK)
def test_it_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(example(name), {"wl": wl})
