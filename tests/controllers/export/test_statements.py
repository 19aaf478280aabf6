"""What becomes of statements: what may be overwritten, what needs no array, and what is carried on."""

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warmlink.controllers.export.c_files import export_files
from warmlink.controllers.export.core import Core, Precision
from warmlink.controllers.export.program import tracing
from warmlink.controllers.export.program.algebra import accumulated, apply, stacked
from warmlink.controllers.export.program.contraction import contracted
from warmlink.controllers.export.program.in_place import may_overwrite
from warmlink.controllers.export.program.noted import Noted
from warmlink.controllers.export.program.places import place_of
from warmlink.controllers.export.program.ranges import is_binary
from warmlink.controllers.export.program.statements import (
    For,
    KnownNumber,
    Operation,
    Read,
    Set,
    Slot,
    Statement,
)
from warmlink.controllers.export.program.tidy import tidied
from warmlink.controllers.export.program.tracing import leaf
from warmlink.controllers.own import Law, component_of
from warmlink.fmus.calls import vectorised_pair
from warmlink.fmus.component import State
from warmlink.fmus.component.arithmetic import accumulated as summed_up
from warmlink.fmus.component.arithmetic import beside, side, truth, where

HERE, OTHER = place_of((4,), ("i",)), place_of((4,), (1,))


def _loop(*body: Statement) -> Statement:
    return For("i", 4, list(body))


def _sum(*of: Read) -> Operation:
    return Operation("add", of)


@pytest.mark.parametrize(
    ("case", "may"),
    [
        ("element by element", True),
        ("another element", False),
        ("read in a loop after it", False),
        ("read in the same turn after it", False),
    ],
)
def test_a_result_may_overwrite_what_is_read_no_more(case: str, may: bool) -> None:
    a, b, r = (Slot(name, (4,)) for name in "abr")
    write: Statement = Set(Read(r, HERE), _sum(Read(a, HERE), Read(b, OTHER)))
    later: Statement = Set(Read(b, HERE), Read(a, HERE))
    bodies: dict[str, list[Statement]] = {
        "element by element": [_loop(later, write)],
        "another element": [_loop(Set(Read(r, HERE), _sum(Read(a, HERE), Read(a, OTHER))))],
        "read in a loop after it": [_loop(write), _loop(later)],
        "read in the same turn after it": [_loop(write, later)],
    }
    assert may_overwrite(bodies[case], r, a) is may


def test_an_array_that_each_turn_needs_alone_becomes_a_number() -> None:
    a, kept, inner = (Slot(name, (4,)) for name in ("a", "kept", "inner"))
    body: list[Statement] = [
        _loop(Set(Read(kept, HERE), Read(a, HERE))),
        _loop(Set(Read(inner, HERE), Read(kept, HERE)), Set(Read(a, HERE), Read(inner, HERE))),
    ]
    made = contracted(body, [kept, inner])
    assert (kept.shape, inner.shape) == ((4,), ())
    assert isinstance(made[1], For)
    assert made[1].body[0] == Set(Read(inner), Read(kept, HERE))


def test_flags_are_known_through_what_is_made_of_them() -> None:
    with tracing.traced(Noted):
        x = leaf("state", "x", ())
        warm, cold = truth(x > 300.0), truth(x < 280.0)
        assert is_binary(apply("larger", warm, cold))
        assert is_binary(1.0 - warm * cold)
        assert is_binary(stacked((warm, 0.0)))
        assert not is_binary(warm + cold)
        assert not is_binary(x)


def test_what_follows_from_the_design_is_worked_out_in_double() -> None:
    with tracing.traced(Noted):
        decay = leaf("design", "decay", (), np.array(0.99941))
        change = decay - 1.0
        assert (change.kind, float(change.value)) == ("leaf", 0.99941 - 1.0)
        assert truth(decay > 0.5).kind == "constant"


def test_what_rounding_leaves_goes_through_vectors_and_choices() -> None:
    with tracing.traced(Noted):
        x, more, asked = leaf("state", "x", (2,)), leaf("input", "more", (2,)), leaf("input", "asked", ())
        assert accumulated(x, more).rest is None
        x.rest = leaf("state", "x_rest", (2,))
        made = accumulated(x, more)
        assert made.rest is not None
        assert made.rest.kind == "left"
        for each in (made[1], stacked((made, 0.0)), where(asked > 0, made, more), beside(made, more)):
            assert each.rest is not None
            assert each.rest.shape == each.shape
        assert (made + 1.0).rest is None


class Slow(Law):
    """Two sums of many small numbers, side by side."""

    states = (State("total", "m", size=4, slow=True),)

    def begin(self, u: Any, p: Any) -> dict[str, Any]:
        """Start values of the states by name."""
        return {"total": 0.0 * u.tip_temperature + np.array([1.0, 2.0, 1.0, 2.0])}

    def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
        """The states after a sample."""
        change = 1e-8 * (u.tip_temperature - 294.0)
        one, other = side(0, x.total), side(1, x.total)
        return {
            "total": beside(summed_up(one, change + 0.0 * one), summed_up(other, 2.0 * change + 0.0 * one))
        }

    def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
        """The correction in m."""
        return 1e-3 * (x.total[2] + x.total[3] - 3.0)


def corrections(precision: Precision, folder: Path, count: int) -> np.ndarray:
    """What the law says to a thermometer at 295.15 K, sample after sample."""
    core = Core(component_of(Slow), "slow", precision)
    for name, text in export_files(core).items():
        (folder / name).write_text(text, encoding="utf-8")
    inputs = ", ".join(repr(float(each.start)) for each in core.component.inputs)
    (folder / "run.c").write_text(
        f"""#include <string.h>
#include "slow.h"
void run(long count, double *said)
{{
    const slow_real v[] = {{{inputs}}};
    slow_inputs u;
    slow law;
    long k;
    memcpy(&u, v, sizeof u);
    slow_init(&law, &u);
    for (k = 0; k < count; k++) {{
        slow_step(&law, &u);
        said[k] = law.outputs.correction;
    }}
}}
""",
        encoding="utf-8",
    )
    command = ["cc", "-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "run.c", "slow.c"]
    subprocess.run([*command, "-lm", "-o", "run.so"], cwd=folder, check=True)
    said = np.zeros(count)
    ctypes.CDLL(str(folder / "run.so")).run(ctypes.c_long(count), said.ctypes.data_as(ctypes.c_void_p))
    return said


def test_single_precision_adds_up_what_is_small_beside_the_sum(tmp_path: Path) -> None:
    """In single precision 1 + 1.15e-8 is 1: without what rounding leaves the sum would stand still."""
    count = 20000
    for name in ("single", "double"):
        (tmp_path / name).mkdir()
    single = corrections("single", tmp_path / "single", count)
    double = corrections("double", tmp_path / "double", count)
    assert double[-1] == pytest.approx(3e-3 * 1.15e-8 * count, rel=1e-6)
    np.testing.assert_allclose(single, double, rtol=0, atol=2e-3 * np.spacing(np.float32(3.0)))


def test_both_of_two_vectorised_pair_are_in_one_loop() -> None:
    def mean(both: Any, share: Any) -> Any:
        """A mean that follows."""
        return both * (1.0 - share) + share * 2.0

    class Paired(Law):
        """Two means side by side."""

        states = (State("means", "m", size=6),)

        def update(self, x: Any, u: Any, p: Any, time: Any, step: Any) -> dict[str, Any]:
            """The states after a sample."""
            return {"means": vectorised_pair(mean, 1)(x.means, 0.001 * u.tip_temperature)}

        def correction(self, x: Any, u: Any, p: Any, time: Any) -> Any:
            """The correction in m."""
            return 1e-6 * x.means[4]

    text = export_files(Core(component_of(Paired), "paired", "double"))["paired.c"]
    assert "for (side = 0; side < 2; side++)" in text
    assert "mean[2 * i + side]" in text or "both[2 * i + side]" in text


def test_neighbouring_loops_become_one_only_where_no_number_changes() -> None:
    a, b, c = (Slot(name, (4,)) for name in "abc")
    first, second = _loop(Set(Read(b, HERE), Read(a, HERE))), _loop(Set(Read(c, HERE), Read(b, HERE)))
    assert tidied([first, second]) == [For("i", 4, [*first.body, *second.body])]
    # Past a known number that neither loop touches, which stays before them.
    known = Set(Read(Slot("n", ())), KnownNumber(1.0))
    assert tidied([first, known, second]) == [known, For("i", 4, [*first.body, *second.body])]
    # Another count, a reading of another turn's element, and a number between that the first loop reads.
    shorter = For("i", 3, second.body)
    turned = _loop(Set(Read(c, HERE), Read(b, OTHER)))
    between = Set(Read(a, OTHER), KnownNumber(0.0))
    for apart in ([first, shorter], [first, turned], [first, between, second]):
        assert tidied(apart) == apart
