"""Native FMUs in other people's tools, each in a process of its own, against the Python instance."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from apart import run_apart

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.component import Component, Input
from warmlink.fmus.component.instance import Instance

from .conftest import BuildNative

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
STEP, STEPS = 0.5, 8
NEEDED = {"fmpy": ("fmpy",), "libcosim": ("libcosimpy",), "ecos": ("ecospy", "tbb")}


def demands(component: Component) -> dict[str, float]:
    """Inputs that do something, none of them at its start value."""
    values: dict[str, float] = {}
    for scalar in component.scalars():
        variable = scalar.variable
        if isinstance(variable, Input):
            moved = 1.0
            if variable.type == "Real":
                moved = variable.start + 0.7 * (5 if variable.unit == "K" else variable.nominal or 1)
            values[scalar.name] = moved if variable.maximum is None else min(moved, variable.maximum)
    return values


def expected(component: Component) -> list[list[float]]:
    instance = Instance(component)
    instance.set(demands(component))
    instance.begin()
    instance.initialize()
    rows = []
    for k in range(STEPS):
        instance.step(k * STEP, STEP)
        rows.append([instance.get(name) for name in component.y.names])
    return rows


def job(fmu: Path, component: Component) -> dict[str, Any]:
    asked = {"fmu": str(fmu), "set": demands(component), "step": STEP, "steps": STEPS}
    return {**asked, "watch": component.y.names}


@pytest.mark.platform
@pytest.mark.parametrize("host", NEEDED)
def test_every_native_fmu_gives_the_instances_numbers(native_fmu: BuildNative, host: str) -> None:
    for package in NEEDED[host]:
        try:
            metadata.version(package)
        except metadata.PackageNotFoundError:
            pytest.skip(f"{package} is not installed")
    jobs = [job(native_fmu(name, "2.0"), component) for name, component in COMPONENTS.items()]
    outcome = run_apart(f"run_{host}", jobs=jobs)
    for result, (name, component) in zip(outcome.result, COMPONENTS.items(), strict=True):
        found = np.array(result["rows"], dtype=float)
        assert found == pytest.approx(np.array(expected(component)), rel=1e-9, abs=1e-15, nan_ok=True), name


@pytest.mark.parametrize("name", COMPONENTS)
def test_fmpy_simulates_fmi_3(native_fmu: BuildNative, name: str) -> None:
    from fmpy import simulate_fmu

    component = COMPONENTS[name]
    result = simulate_fmu(
        str(native_fmu(name, "3.0")),
        stop_time=STEP * STEPS,
        step_size=STEP,
        output_interval=STEP,
        start_values=demands(component),
        output=component.y.names,
    )
    found = np.array([[float(row[output]) for output in component.y.names] for row in result[1:]])
    assert found == pytest.approx(np.array(expected(component)), rel=1e-9, abs=1e-15, nan_ok=True)
