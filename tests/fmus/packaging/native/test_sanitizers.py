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
SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", COMPONENTS)
def test_sanitizers_find_nothing(
    name: str, version: FmiVersion, c_compiler: Compiler, tmp_path: Path
) -> None:
    sources, _ = native_sources(COMPONENTS[name], version)
    for file, text in sources.items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    driver = HERE / f"drive_fmi{version[0]}.c"
    units = [file for file in sources if file.endswith(".c")]
    # The generated functions are straight lines of arithmetic: unoptimised they compile in a moment.
    command = [*c_compiler.command, "-std=c99", "-O0", "-Wall", "-Wextra", "-pedantic", "-Wno-unused"]
    include = ["-I.", f"-I{header_folder()}"]
    built = subprocess.run(
        [*command, *SANITIZERS, *include, str(driver), *units, "-o", "driven", "-lm"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    if built.returncode != 0 and "san" in built.stderr and "cannot find" in built.stderr:
        pytest.skip("the compiler's sanitizers are not installed")
    assert built.returncode == 0, built.stderr[-2000:]
    assert "warning" not in built.stderr, built.stderr[:2000]
    done = subprocess.run(
        [str(tmp_path / "driven")],
        capture_output=True,
        text=True,
        env={**os.environ, "ASAN_OPTIONS": "detect_leaks=1"},
    )
    assert done.returncode == 0, done.stderr[-3000:]
