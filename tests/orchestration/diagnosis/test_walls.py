"""The rooms of the diagnosis: what may import what, and how large they may become."""

import ast
from pathlib import Path

import pytest

import warmlink.orchestration.diagnosis.data as data

HOME = Path(data.__file__).parents[1]
PREFIX = "warmlink.orchestration.diagnosis."
BELOW = {
    "causes": (),
    "data": ("causes",),
    "model": ("data",),
    "fit": ("data", "model", "causes"),
    "ladder": ("data", "model", "causes", "fit"),
    "answer": ("data", "model", "causes", "fit", "ladder"),
    "terms": ("data", "model", "causes", "fit", "ladder", "answer"),
    "practice": ("data", "causes"),
    "arm": ("data", "causes", "answer", "practice", "diagnose"),
}
"""Rooms that each room may import."""


def modules(tree: ast.AST) -> set[str]:
    return {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}


def test_every_room_is_listed() -> None:
    assert {path.parent.name for path in HOME.glob("*/__init__.py")} == set(BELOW)


@pytest.mark.parametrize("room", BELOW)
def test_a_room_imports_only_rooms_below_it(room: str) -> None:
    for path in (HOME / room).glob("*.py"):
        imported = modules(ast.parse(path.read_text("utf-8")))
        rooms = {name.removeprefix(PREFIX).partition(".")[0] for name in imported if name.startswith(PREFIX)}
        assert rooms <= {room, *BELOW[room]}, path.name
        assert not any(name.startswith("warmlink.orchestration.report") for name in imported), path.name


def test_modules_import_each_other_in_no_circle() -> None:
    wanted = {}
    for path in HOME.rglob("*.py"):
        name = PREFIX + ".".join(path.relative_to(HOME).with_suffix("").parts)
        wanted[name] = modules(ast.parse(path.read_text("utf-8")))
    left = {name: imported & set(wanted) for name, imported in wanted.items()}
    while free := [name for name, imported in left.items() if not imported & set(left)]:
        for name in free:
            del left[name]
    assert not left


def test_rooms_and_files_are_small() -> None:
    for room in BELOW:
        files = list((HOME / room).glob("*.py"))
        assert len(files) <= 16
        assert all(len(path.read_text("utf-8").splitlines()) <= 320 for path in files)
