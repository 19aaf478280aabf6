"""Outputs are computed together where they share their work, and apart where they do not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Input, Output
from warmlink.fmus.component.arithmetic import Number, cos, exp, sin
from warmlink.fmus.packaging.native.groups import LARGEST_COUNT, output_groups


def observe(x: Any, u: Any, p: Any, time: Number) -> Mapping[str, Number]:
    common = sin(exp(u.a)) * cos(u.b) + u.a * u.b
    return {"first": common + 1, "second": u.a, "third": 2 * common, "fourth": exp(u.b)}


def test_shared_work_makes_a_group() -> None:
    component = Component(
        name="Shares",
        description="two outputs of one sum",
        observe=observe,
        inputs=(Input("a", "1", "a"), Input("b", "1", "b")),
        outputs=tuple(Output(name, "1", name) for name in ("first", "second", "third", "fourth")),
    )
    assert output_groups(component) == [[0, 2], [1], [3]]


@pytest.mark.parametrize("entry", catalogue(), ids=lambda entry: entry.component.name)
def test_every_output_is_in_one_group(entry: Any) -> None:
    groups = output_groups(entry.component)
    assert sorted(i for group in groups for i in group) == list(range(entry.component.y.size))
    assert len(groups) <= LARGEST_COUNT
