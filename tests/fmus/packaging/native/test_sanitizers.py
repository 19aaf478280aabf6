"""FMUs of each kind, with sanitizers for addresses and undefined behaviour, driven through all they offer."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from warmlink.fmus.packaging.native.compile import Compiler

from .sanitized import COMPONENTS, KINDS, VERSIONS, compile_sanitized

pytestmark = pytest.mark.xdist_group("sanitized")

HERE = Path(__file__).parent
LARGE = ("ThermalLink", "ObserverDriftCompensator")
ALIKE = {
    "HeatPath": "Heater",
    "PoseSequence": "DutyCycle",
    "AnalyticCompensator": "LagCompensator",
    "NoCompensator": "LagCompensator",
    "ObserverCompensator": "ObserverDriftCompensator",
    "LinearObserverCompensator": "ObserverDriftCompensator",
}
"""Components whose C has nothing that another one's has not, and that one."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n in LARGE else n for n in COMPONENTS if n not in ALIKE],
)
def test_sanitizers_find_nothing(name: str, c_compiler: Compiler, sanitized_folder: Path) -> None:
    """What is generated is the same for both versions; of FMI 2.0's own C one of each kind shows enough."""
    for version in VERSIONS if name in (*KINDS, "RecordedDuty") else ("3.0",):
        driver = HERE / "drivers" / f"drive_fmi{version[0]}.c"
        program = compile_sanitized(name, version, c_compiler, sanitized_folder, driver)
        environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1"}
        done = subprocess.run([program], capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("name", ["Heater", "TemperatureSensors"])
def test_nothing_in_the_run_asks_for_memory(name: str, c_compiler: Compiler, sanitized_folder: Path) -> None:
    wrapped = [f"-Wl,--wrap={function}" for function in ("malloc", "calloc", "realloc")]
    program = compile_sanitized(
        name, "3.0", c_compiler, sanitized_folder, HERE / "drivers" / "count_allocations.c", *wrapped
    )
    done = subprocess.run([program], capture_output=True, text=True)
    exchanges = name == "Heater"
    assert done.stdout == f"100 steps, 0 requests, {1 + exchanges} before\n", done.stderr[-2000:]
