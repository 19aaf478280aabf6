"""Native FMUs linked with a driver in C, under sanitizers for addresses and undefined behaviour."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import FmiVersion, header_folder, native_sources

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")

_GENERATED = ("starting.c", "running.c", "variables.c")
_SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
_ARITHMETIC = ("-fno-sanitize=null,alignment,object-size,pointer-overflow",)
"""What the generated functions need no check for: their places in arrays are constants, and the sanitizer for
addresses watches each of them."""


def compile_sanitized(
    name: str, version: FmiVersion, compiler: Compiler, folder: Path, driver: Path, *options: str
) -> Path:
    """Program of a driver and a component's FMU; in one folder each unit of an FMU is compiled once."""
    # The generated functions are straight lines of arithmetic: unoptimised they compile in a moment.
    command = [*compiler.command, "-std=c99", "-O0", "-Wall", "-Wextra", "-pedantic", "-Wno-unused"]
    command += [*_SANITIZERS, "-I.", f"-I{header_folder()}"]
    shared, home = folder / name, folder / name / version
    home.mkdir(parents=True, exist_ok=True)
    objects = [f"../{file.replace('.c', '.o')}" for file in _GENERATED]
    units = ["model.c", f"fmi{version[0]}_cs.c"]
    if not (home / "model.o").is_file():
        sources, _ = native_sources(COMPONENTS[name], version)
        for file, text in sources.items():
            (home / file).write_text(text, encoding="utf-8")
        if not (home / objects[0]).is_file():
            _compile([*command, *_ARITHMETIC, "-c", *_GENERATED], home)
            for file in objects:
                (home / Path(file).name).rename(home / file)
        _compile([*command, "-c", *units], home)
    objects += [unit.replace(".c", ".o") for unit in units]
    program = shared / f"{driver.stem}_fmi{version[0]}"
    _compile([*command, *options, str(driver), *objects, "-o", str(program), "-lm"], home)
    return program


def _compile(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0 and "san" in done.stderr and "cannot find" in done.stderr:
        pytest.skip("the compiler's sanitizers are not installed")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "warning" not in done.stderr, done.stderr[:2000]
