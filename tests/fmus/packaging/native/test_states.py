"""State: restored at random times, across instances and through bytes; and starting anew."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Input
from warmlink.fmus.packaging.native.fmu import FmiVersion

from .conftest import BuildNative
from .running import Native

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}


def excite(component: Component, native: Native, index: int) -> None:
    for i, scalar in enumerate(component.scalars()):
        if isinstance(scalar.variable, Input) and scalar.variable.type == "Real":
            size = scalar.variable.nominal or 1.0
            assert scalar.start is not None
            native.set({scalar.name: scalar.start + size * 0.01 * ((index * 7 + i * 3) % 5)})


def run(component: Component, native: Native, steps: range, step: float = 2.5) -> list[list[float]]:
    rows = []
    for i in steps:
        excite(component, native, i)
        native.step(i * step, step)
        rows.append([native.get(name) for name in component.y.names])
    return rows


def saving(native: Native) -> tuple[Callable[[], object], Callable[[object], None]]:
    if native.modern:
        return native.fmu.getFMUState, native.fmu.setFMUState
    return native.fmu.getFMUstate, native.fmu.setFMUstate


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", COMPONENTS)
def test_what_follows_a_restored_state_is_the_same_to_the_last_bit(
    name: str, version: FmiVersion, native_fmu: BuildNative
) -> None:
    component = COMPONENTS[name]
    first = Native(native_fmu(name, version), component)
    first.initialize()
    run(component, first, range(13))
    save, restore = saving(first)
    state = save()
    expected = run(component, first, range(13, 40))
    restore(state)
    assert str(run(component, first, range(13, 40))) == str(expected)

    content = bytes((first.fmu.serializeFMUState if first.modern else first.fmu.serializeFMUstate)(state))
    second = Native(native_fmu(name, version), component, "second")
    read = second.fmu.deserializeFMUState if second.modern else second.fmu.deSerializeFMUstate
    saving(second)[1](read(content))
    assert str(run(component, second, range(13, 40))) == str(expected)
    first.close()
    second.close()


def test_parameters_belong_to_the_state(native_fmu: BuildNative) -> None:
    link = COMPONENTS["ThermalLink"]
    wide, narrow = (Native(native_fmu("ThermalLink", "2.0"), link, name) for name in ("wide", "narrow"))
    for native, width in ((wide, 0.05), (narrow, 0.02)):
        native.set({"width": width, "heat_flow": 5.0})
        native.initialize()
    expected = run(link, wide, range(3))
    wide_again = wide.fmu.serializeFMUstate(wide.fmu.getFMUstate())
    expected += run(link, wide, range(3, 6))
    narrow.fmu.setFMUstate(narrow.fmu.deSerializeFMUstate(wide_again))
    assert narrow.get("width") == 0.05
    assert run(link, narrow, range(3, 6)) == expected[3:]
    wide.close()
    narrow.close()


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_after_a_reset_the_run_is_the_first_run(version: FmiVersion, native_fmu: BuildNative) -> None:
    link = COMPONENTS["ThermalLink"]
    native = Native(native_fmu("ThermalLink", version), link)
    native.initialize()
    expected = run(link, native, range(5))
    native.fmu.reset()
    native.set({"width": 0.05})
    native.initialize(start=5.0)
    native.step(5.0, 1.0)
    native.fmu.reset()
    native.initialize()
    assert run(link, native, range(5)) == expected
    native.close()


def test_many_instances_run_in_many_threads_as_one_does_alone(native_fmu: BuildNative) -> None:
    from concurrent.futures import ThreadPoolExecutor

    link = COMPONENTS["ThermalLink"]
    path = native_fmu("ThermalLink", "2.0")

    def alone(width: float) -> list[list[float]]:
        native = Native(path, link, f"w{width:g}")
        native.set({"width": width})
        native.initialize()
        rows = run(link, native, range(60))
        native.close()
        return rows

    widths = [0.01 + 0.002 * i for i in range(8)]
    expected = [alone(width) for width in widths]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(alone, widths)) == expected
    assert expected[0] != expected[1]
