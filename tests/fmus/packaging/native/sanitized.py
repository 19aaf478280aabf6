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
    """Program of a driver and a component's FMU; what both versions share is compiled once a folder."""
    # The generated functions are straight lines of arithmetic: unoptimised they compile in a moment.
    command = [*compiler.command, "-std=c99", "-O0", "-Wall", "-Wextra", "-pedantic", "-Wno-unused"]
    command += [*_SANITIZERS, "-I.", f"-I{header_folder()}", *options]
    sources, _ = native_sources(COMPONENTS[name], version)
    for file, text in sources.items():
        (folder / file).write_text(text, encoding="utf-8")
    objects = [file.replace(".c", ".o") for file in _GENERATED]
    if not (folder / objects[0]).is_file():
        _compile([*command, *_ARITHMETIC, "-c", *_GENERATED], folder)
    program = folder / f"{driver.stem}_fmi{version[0]}"
    wrapper = f"fmi{version[0]}_cs.c"
    _compile([*command, str(driver), "model.c", wrapper, *objects, "-o", str(program), "-lm"], folder)
    return program


def _compile(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0 and "san" in done.stderr and "cannot find" in done.stderr:
        pytest.skip("the compiler's sanitizers are not installed")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "warning" not in done.stderr, done.stderr[:2000]
