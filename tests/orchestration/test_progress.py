"""Progress: on a terminal, in a notebook, and a line now and then where nobody watches."""

from __future__ import annotations

import ast
import inspect
import io
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from warmlink.orchestration import progress
from warmlink.orchestration.cli import command_named, ours
from warmlink.orchestration.command_line.arguments import carry_out
from warmlink.orchestration.progress import progress_bar, spinner, stretch, without_progress_lines


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Seconds that the console's clock shows; its own watch does not look."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(progress, "_POLL", 1e6)
    return now


def lines(capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Lines on standard error since the last call; none on standard output."""
    out, err = capsys.readouterr()
    assert not out
    return err.splitlines()


def test_a_line_comes_after_20_s_and_then_every_30_s(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with spinner("Diagnosing run.csv") as show:
        for clock[0] in np.arange(0.0, 20.0):
            show("reading", 0.01)
        assert not lines(capsys)
        clock[0] = 20.0
        show("causes: set 4 of at most 45, paint", 0.25)
        told = "causes: set 4 of at most 45, paint; 25 % in 20 s, about 60 s left"
        assert lines(capsys) == [f"warmlink: Diagnosing run.csv: {told}"]
        for clock[0] in np.arange(21.0, 50.0):
            show("causes", 0.3)
        assert not lines(capsys)
        for clock[0] in np.arange(50.0, 320.0):
            show("causes", 0.5)
        assert len(lines(capsys)) == 9
    with progress_bar("12 runs") as share:
        clock[0] += 7200.0
        share(0.4, "best 2 um")
        assert lines(capsys) == ["warmlink: 12 runs: best 2 um; 40 % in 2 h 00 min, about 3 h 00 min left"]


def test_a_share_is_not_needed_and_too_small_a_one_foretells_nothing(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with spinner("Compiling") as show:
        clock[0] = 50.0
        show("system 1 of 2")
        clock[0] = 200.0
        show("system 1 of 2", 0.001)
    assert lines(capsys) == [
        "warmlink: Compiling: system 1 of 2; 50 s so far",
        "warmlink: Compiling: system 1 of 2; 0 % in 3 min",
    ]


def test_a_line_comes_although_nothing_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, seconds in (("_FIRST", 0.1), ("_AGAIN", 60.0), ("_POLL", 0.01)):
        monkeypatch.setattr(progress, name, seconds)
    with spinner("Compiling"):
        deadline, shown = time.monotonic() + 30.0, []
        while not shown and time.monotonic() < deadline:
            time.sleep(0.01)
            shown = lines(capsys)
    assert shown == ["warmlink: Compiling; 0 s so far"]


@pytest.mark.parametrize("values", [{"json": True}, {"quiet": True}, {"json": False}, {}])
def test_another_program_is_shown_none(
    values: dict[str, Any], clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    def command(**_: Any) -> None:
        with spinner("Diagnosing") as show:
            clock[0] += 100.0
            show("reading")

    carry_out(command, values)
    assert bool(lines(capsys)) == (not any(values.values()))


def test_lines_come_again_after_a_command_for_another_program(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ValueError, match="no"), without_progress_lines():
        raise ValueError("no")
    with spinner("Reducing") as show:
        clock[0] += 100.0
        show("meshing")
    assert len(lines(capsys)) == 1


def test_a_part_of_the_work_goes_from_its_first_share_to_its_last() -> None:
    seen: list[tuple[str, float | None]] = []
    part = stretch(lambda doing, share=None, /: seen.append((doing, share)), 0.2, 0.6)
    part("a")
    stretch(part, 0.5, 1.0)("b", 0.5)
    assert seen == [("a", 0.2), ("b", pytest.approx(0.5))]


def test_a_terminal_shows_what_is_done_and_how_much(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.StringIO()
    shown.isatty = lambda: True  # type: ignore[method-assign]
    for name, value in (("TERM", "xterm"), ("COLUMNS", "120")):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.stderr", shown)
    with spinner("Reducing") as show:
        show("meshing", 0.5)
    assert "Reducing meshing" in shown.getvalue()
    assert shown.getvalue().endswith("\x1b[1A\x1b[2K"), "and leaves nothing behind"


SHORT = {"save", "plot", "export", "info", "init", "schema", "list"}
"""Commands that are done before anybody waits."""


@pytest.mark.parametrize("name", sorted(ours().keys() - SHORT))
def test_each_long_command_shows_its_progress(name: str) -> None:
    """The command, or a function that it calls, opens a progress and tells it something."""
    assert any(map(_tells, _reached(command_named(name)))), name


def _reached(command: Any, depth: int = 3) -> Iterator[ast.AST]:
    """Trees of a function, and of the functions and classes of the library that it names, so many deep."""
    module = sys.modules[command.__module__]
    tree = ast.parse(inspect.getsource(inspect.unwrap(command)))
    yield tree
    if depth:
        imported = {
            each.asname or each.name: (node.module, each.name)
            for node in [*ast.walk(tree), *ast.walk(ast.parse(inspect.getsource(module)))]
            if isinstance(node, ast.ImportFrom) and node.module
            for each in node.names
        }
        for used in sorted({n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}):
            place, called = imported.get(used, (command.__module__, used))
            if place.startswith("warmlink.orchestration"):
                found = getattr(__import__(place, fromlist=["*"]), called, None)
                if (inspect.isfunction(found) or inspect.isclass(found)) and found is not command:
                    yield from _reached(found, depth - 1)


def _tells(tree: ast.AST) -> bool:
    """Whether a function opens a progress by `with ... as`, and uses it."""
    names = {
        item.optional_vars.id
        for node in ast.walk(tree)
        if isinstance(node, ast.With)
        for item in node.items
        if isinstance(item.context_expr, ast.Call)
        and isinstance(item.context_expr.func, ast.Name)
        and item.context_expr.func.id in ("spinner", "progress_bar")
        and isinstance(item.optional_vars, ast.Name)
    }
    used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    return bool(names & used)


@pytest.mark.parametrize("terminal", [True, False])
def test_what_is_begun_meanwhile_is_a_part(
    terminal: bool, clock: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A library that draws two bars at once would refuse the second."""
    shown = io.StringIO()
    shown.isatty = lambda: terminal  # type: ignore[method-assign]
    for name, value in (("TERM", "xterm"), ("COLUMNS", "120")):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.stderr", shown)
    with spinner("Checking") as show:
        show("runs", 0.5)
        with progress_bar("cell") as share:
            clock[0] = 20.0
            share(0.1)
    told = "Checking cell" if terminal else "Checking: cell; 50 % in 20 s, about 20 s left\n"
    assert told in shown.getvalue()
    with spinner("Diagnosing"):
        pass
