"""Every FMU, built with sanitizers for addresses and undefined behaviour, driven through all it offers."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from warmlink.fmus.packaging.catalogue import catalogue
from warmlink.fmus.packaging.compile import Compiler
from warmlink.fmus.packaging.native_fmu import FmiVersion, header_folder, native_sources

HERE = Path(__file__).parent
COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")
GENERATED = ("starting.c", "running.c", "variables.c")
SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


@pytest.mark.parametrize("name", COMPONENTS)
def test_sanitizers_find_nothing(name: str, c_compiler: Compiler, tmp_path: Path) -> None:
    # The generated functions are straight lines of arithmetic: unoptimised they compile in a moment.
    command = [*c_compiler.command, "-std=c99", "-O0", "-Wall", "-Wextra", "-pedantic", "-Wno-unused"]
    command += [*SANITIZERS, "-I.", f"-I{header_folder()}"]
    for version in VERSIONS:
        sources, _ = native_sources(COMPONENTS[name], version)
        for file, text in sources.items():
            (tmp_path / file).write_text(text, encoding="utf-8")
        if version == VERSIONS[0]:
            compile_apart([*command, "-c", *GENERATED], tmp_path)
        objects = [file.replace(".c", ".o") for file in GENERATED]
        wrapper = f"fmi{version[0]}_cs.c"
        driver = str(HERE / f"drive_fmi{version[0]}.c")
        compile_apart([*command, driver, "model.c", wrapper, *objects, "-o", "driven", "-lm"], tmp_path)
        environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1"}
        done = subprocess.run([str(tmp_path / "driven")], capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr[-3000:]


def compile_apart(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0 and "san" in done.stderr and "cannot find" in done.stderr:
        pytest.skip("the compiler's sanitizers are not installed")
    assert done.returncode == 0, done.stderr[-2000:]
    assert "warning" not in done.stderr, done.stderr[:2000]
