"""C means what the statements mean: brackets where they are wanted, and assignments in short."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.export.c_text import C
from warmlink.controllers.export.program.expressions import FUNCTIONS
from warmlink.controllers.export.program.program import LawProgram
from warmlink.controllers.export.program.statements import (
    Index,
    KnownNumber,
    Operation,
    Read,
    Routine,
    Set,
    Slot,
    Value,
)
from warmlink.fmus.packaging.native.compile import library_here
from warmlink.fmus.packaging.native.library import loaded

NOTHING = Routine("nothing", "", [])
C_TEXT = C("law", LawProgram([], [], [], [], [], [], NOTHING, NOTHING, NOTHING, timed=False), single=False)
KNOWN, COUNT = np.array([2.5, -0.75, 0.0, 3.0, np.nan]), 400
HELD, TOTAL = Slot("x", (KNOWN.size,)), Slot("total")

ONE, TWO = ("neg", "abs", "sqrt", "floor"), ("add", "sub", "mul", "div")
COMPARED = ("lt", "le", "gt", "ge", "eq")


def number(rng: np.random.Generator, depth: int) -> Value:
    """A tree whose value is a number."""
    if depth == 0 or rng.random() < 0.15:
        place = Index(int(rng.integers(KNOWN.size)))
        return Read(HELD, place) if rng.random() < 0.7 else KnownNumber(float(rng.choice([-1.5, 0.1, 7.0])))
    kind = str(rng.choice([*ONE, *TWO, *["select"] * 4]))
    if kind == "select":
        return Operation(kind, (condition(rng, depth - 1), number(rng, depth - 1), number(rng, depth - 1)))
    return Operation(
        kind, tuple(number(rng, depth - 1) for _ in range(1 + (kind in ("add", "sub", "mul", "div"))))
    )


def condition(rng: np.random.Generator, depth: int) -> Value:
    """A tree that holds or does not."""
    kind = str(rng.choice([*COMPARED, "and", "or", "not"] if depth > 1 else COMPARED))
    of = condition if kind in ("and", "or", "not") else number
    return Operation(kind, tuple(of(rng, max(depth - 1, 0)) for _ in range(2 - (kind == "not"))))


def meant(value: Value) -> Any:
    """Value of a tree by NumPy."""
    if isinstance(value, KnownNumber):
        return np.float64(value.value)
    if isinstance(value, Read):
        assert value.index is not None
        return KNOWN[value.index.constant]
    with np.errstate(all="ignore"):
        return FUNCTIONS[value.kind](*map(meant, value.of))


def computed(lines: list[str]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What so many statements leave in `total`, each by itself from 2.5 on."""
    body = "".join(f"  total = 2.5; {line} y[{i}] = total;\n" for i, line in enumerate(lines))
    exported = '#include <math.h>\n__attribute__((visibility("default")))\n'
    text = f"{exported}void all(const double *x, double *y)\n{{\n  double total;\n{body}}}\n"
    found = np.empty(len(lines))
    loaded(library_here({"all.c": text}, "all", "-O0")).all(
        *(v.ctypes.data_as(ctypes.c_void_p) for v in (KNOWN, found))
    )
    return found


@pytest.mark.parametrize("seed", [0, 1])
def test_what_is_printed_is_the_tree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trees = [number(rng, 4) for _ in range(COUNT)]
    found = computed([C_TEXT.assigned(Set(Read(TOTAL), tree)) for tree in trees])
    np.testing.assert_array_equal(found, [float(meant(tree)) for tree in trees])
    assert np.isfinite(found).sum() > COUNT / 4


@pytest.mark.parametrize("kind", TWO)
def test_an_assignment_that_changes_a_variable_is_the_same_in_short(kind: str) -> None:
    rng = np.random.default_rng(2)
    trees = [number(rng, 2) for _ in range(50)]
    lines = [C_TEXT.assigned(Set(Read(TOTAL), Operation(kind, (Read(TOTAL), tree)))) for tree in trees]
    with np.errstate(all="ignore"):
        expected = [float(FUNCTIONS[kind](2.5, meant(tree))) for tree in trees]
    np.testing.assert_array_equal(computed(lines), expected)


@pytest.mark.parametrize(("value", "single"), [(np.inf, False), (-np.inf, True), (1e39, True), (0.1, True)])
def test_a_number_of_either_precision_is_finite(value: float, single: bool) -> None:
    text = C("law", C_TEXT.program, single).number(value)
    assert text.endswith("f") == single
    assert float(text.removesuffix("f")) == (value if abs(value) < 3e38 else np.copysign(3e38, value))
