"""Joined components in Python and in C: which part is sampled first, and what the parts begin with."""

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

RAMP = Component(
    name="Ramp",
    description="Gives the time",
    outputs=(Output("now", "s", "time"),),
    observe=lambda x, u, p, time: {"now": 1.0 * time},
)
COUNTS = Component(
    name="Counts",
    description="Counts its samples",
    parameters=(Parameter("sample_time", "s", 0.1, "time between two", minimum=1e-3),),
    states=(State("number", "s"),),
    outputs=(Output("count", "s", "samples so far, as if each were a second"),),
    update=lambda x, u, p, time, step: {"number": x.number + 1.0},
    observe=lambda x, u, p, time: {"count": x.number},
)
FOLLOWS = Component(
    name="Follows",
    description="Holds what it has seen in its last sample, or at the start",
    inputs=(Input("seen", "s", "what it looks at"),),
    parameters=(Parameter("sample_time", "s", 0.3, "time between two", minimum=1e-3),),
    states=(State("held", "s"),),
    outputs=(Output("last", "s", "what it saw"),),
    begin=lambda u, p: {"held": u.seen},
    update=lambda x, u, p, time, step: {"held": u.seen},
    observe=lambda x, u, p, time: {"last": x.held},
)
WHOLE = join(
    "Whole",
    {"ramp": RAMP, "counts": COUNTS, "follows": FOLLOWS, "watch": FOLLOWS},
    [("counts.count", "follows.seen"), ("ramp.now", "watch.seen")],
)
SAMPLES = 50


@pytest.fixture(params=["Python", "native"])
def running(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Instance | Native]:
    if request.param == "Python":
        yield Instance(WHOLE)
        return
    compiler: Compiler = request.getfixturevalue("c_compiler")
    path = tmp_path / "Whole.fmu"
    write_archive(path, native_fmu_files(Entry(WHOLE, __name__), "2.0", [compiler]))
    native = Native(path, WHOLE)
    yield native
    native.close()


def test_of_samples_due_at_once_the_first_parts_comes_first(running: Instance | Native) -> None:
    """Three times 0.1 s is more than 0.3 s to a computer."""
    running.initialize()
    running.step(0.0, 0.05)
    seen = []
    for k in range(SAMPLES):
        running.step(0.05 + 0.3 * k, 0.3)
        seen.append(running.get("follows.last"))
    assert seen == [3.0 * (k + 1) for k in range(SAMPLES)]


def test_parts_begin_with_what_others_give_at_the_start_of_the_run(running: Instance | Native) -> None:
    if isinstance(running, Instance):
        running.begin(1000.0)
        running.initialize()
    else:
        running.initialize(1000.0)
    assert running.get("watch.last") == running.get("ramp.now") == 1000.0
