"""The libraries run in a program of plain C, in a process without Python, and give what Python gives."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion
from warmlink.fmus.thermal_link.component import COMPONENT

from .bare_host import arguments, compile_host, hour_in_python
from .conftest import BuildNative

PLACE = {"2.0": "fmi2", "3.0": "name"}


@pytest.fixture(scope="module")
def expected() -> list[float]:
    return hour_in_python(COMPONENT)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_hour_in_plain_c_equals_the_python_instance(
    version: FmiVersion, native_fmu: BuildNative, c_compiler: Compiler, expected: list[float], tmp_path: Path
) -> None:
    host = compile_host(c_compiler, version, tmp_path)
    place = getattr(c_compiler.platform, PLACE[version])
    library = f"binaries/{place}/{COMPONENT.name}{c_compiler.platform.suffix}"
    given = arguments(COMPONENT, native_fmu(COMPONENT.name, version), library, tmp_path / "fmu")
    done = subprocess.run([str(host), *given], capture_output=True, text=True, env={})
    assert done.stderr == ""
    results = [float(line) for line in done.stdout.split()]
    assert results[:-1] == pytest.approx(expected, rel=1e-9, abs=1e-15)
    # The run is no standstill: the link has grown.
    assert results[COMPONENT.y.index["elongation"]] > 1e-5
