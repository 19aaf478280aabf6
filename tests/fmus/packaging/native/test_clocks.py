"""Clocks of different periods: of samples due at once, the first part's comes first, whatever rounding says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component, Input, Output, Parameter, State
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.component.join import join
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import native_fmu_files

from .running import Native

COUNTS = Component(
    name="Counts",
    description="Counts its samples",
    parameters=(Parameter("sample_time", "s", 0.1, "time between two", minimum=1e-3),),
    states=(State("number", "1"),),
    outputs=(Output("count", "1", "samples so far"),),
    update=lambda x, u, p, time, step: {"number": x.number + 1.0},
    observe=lambda x, u, p, time: {"count": x.number},
)
FOLLOWS = Component(
    name="Follows",
    description="Holds what it has seen in its last sample",
    inputs=(Input("seen", "1", "what it looks at"),),
    parameters=(Parameter("sample_time", "s", 0.3, "time between two", minimum=1e-3),),
    states=(State("held", "1"),),
    outputs=(Output("last", "1", "what it saw"),),
    update=lambda x, u, p, time, step: {"held": u.seen},
    observe=lambda x, u, p, time: {"last": x.held},
)
BOTH = join("Both", {"first": COUNTS, "second": FOLLOWS}, [("first.count", "second.seen")])
SAMPLES = 50


@pytest.fixture(params=["Python", "native"])
def running(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Instance | Native]:
    if request.param == "Python":
        yield Instance(BOTH)
        return
    compiler: Compiler = request.getfixturevalue("c_compiler")
    path = tmp_path / "Both.fmu"
    write_archive(path, native_fmu_files(Entry(BOTH, __name__), "2.0", [compiler]))
    native = Native(path, BOTH)
    yield native
    native.close()


def test_of_samples_due_at_once_the_first_parts_comes_first(running: Instance | Native) -> None:
    """Three times 0.1 s is more than 0.3 s to a computer."""
    running.initialize()
    running.step(0.0, 0.05)
    seen = []
    for k in range(SAMPLES):
        running.step(0.05 + 0.3 * k, 0.3)
        seen.append(running.get("second.last"))
    assert seen == [3.0 * (k + 1) for k in range(SAMPLES)]
