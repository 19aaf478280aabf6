"""A step that leaves out what is rare gives the bits of the step with all, where that brings nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component

from .conftest import BuildNative
from .running import Native

RARE = {
    entry.component.name: (entry.component, [each.name for each in entry.component.parameters if each.rare])
    for entry in catalogue()
    if entry.component.continuous.size
}
NOTHING = 1e-300
"""Not 0, and too small to change any sum."""


def warmed(path: Path, component: Component, rare: dict[str, float]) -> list[list[float]]:
    """Outputs over an hour in which every input differs from its start."""
    native = Native(path, component)
    native.set(rare)
    inputs = [scalar for scalar in component.scalars() if scalar.variable in component.inputs]
    native.initialize()
    native.set(
        {s.name: s.start + (1 if s.variable.type != "Real" else s.variable.nominal or 1) for s in inputs}
    )
    found = []
    for k in range(60):
        native.step(60.0 * k, 60.0)
        found.append([native.get(name) for name in component.y.names[: component.output_count]])
    native.close()
    return found


@pytest.mark.parametrize("name", [name for name, (_, rare) in RARE.items() if rare])
def test_what_is_rare_changes_no_bit_where_it_brings_nothing(name: str, native_fmu: BuildNative) -> None:
    component, rare = RARE[name]
    path = native_fmu(name, "2.0")
    without = warmed(path, component, {})
    assert without == warmed(path, component, dict.fromkeys(rare, NOTHING))
    largest = {scalar.name: scalar.variable.maximum for scalar in component.scalars()}
    for each in rare:
        some = min(0.01, largest[each] if largest[each] is not None else 0.01)
        assert without != warmed(path, component, {each: some}), f"{each} changes nothing"
