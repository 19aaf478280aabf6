"""Native FMUs linked with a driver in C, under sanitizers for addresses and undefined behaviour."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.built import Ended, built
from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.packaging.beside import table_files
from warmlink.fmus.packaging.native.compile import Compiler, _needed
from warmlink.fmus.packaging.native.fmu import FmiVersion, header_folder, native_sources

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")
KINDS = ("DriftCamera", "DutyCycle", "Heater", "TemperatureSensors")
"""One of each kind: with and without states, integrating and sampling, integer outputs, readings of NaN."""

_GENERATED = ("starting.c", "running.c", "deriving.c", "variables.c")
_SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
_ARITHMETIC = ("-fno-sanitize=null,alignment,object-size,pointer-overflow",)
"""What the generated functions need no check for: their places in arrays are constants, and the sanitizer for
addresses watches each of them."""


def compile_sanitized(
    name: str, version: FmiVersion, compiler: Compiler, folder: Path, driver: Path, *options: str
) -> Path:
    """Program of a driver and a component's FMU; each unit of an FMU is compiled once, and kept."""
    # The generated functions are straight lines of arithmetic: unoptimised they compile in a moment.
    command = [*compiler.command, "-std=c99", "-O0", "-Wall", "-Wextra", "-pedantic"]
    command += [*_SANITIZERS, "-I.", f"-I{header_folder()}"]
    home = folder / name / version
    home.mkdir(parents=True, exist_ok=True)
    sources, _ = native_sources(COMPONENTS[name], version)
    for file, text in sources.items():
        (home / file).write_text(text, encoding="utf-8")
    for place, content in table_files(COMPONENTS[name]).items():
        (home / place).parent.mkdir(exist_ok=True)
        (home / place).write_bytes(content)
    options = (f'-DRESOURCES="{home / "resources"}"', *options)
    headers = [each.read_bytes() for each in sorted(header_folder().glob("*.h"))]
    units = {unit: _ARITHMETIC if unit in _GENERATED else () for unit in sources if unit.endswith(".c")}
    for unit, more in units.items():
        made_from = _needed(unit, sources), headers
        built([*command, *more, "-c", unit], made_from, home / f"{unit}.o", _judge)
    program = folder / name / f"{driver.stem}_fmi{version[0]}"
    objects = [f"{unit}.o" for unit in units]
    command += [*options, str(driver), *objects, "-o", str(program), "-lm"]
    _judge(subprocess.run(command, cwd=home, capture_output=True, text=True))
    return program


def _judge(done: Ended) -> None:
    if done.returncode != 0 and "san" in done.stderr and "cannot find" in done.stderr:
        pytest.skip("the compiler's sanitizers are not installed")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "warning" not in done.stderr, done.stderr[:2000]
