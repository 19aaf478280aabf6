"""What the C looks like from outside: symbols, libraries, sources inside, sizes, and the compilers chosen."""

from __future__ import annotations

import importlib.util
import re
import struct
import subprocess
from pathlib import Path
from zipfile import ZipFile

import pytest
from fmpy import read_model_description

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.errors import InputError
from warmlink.fmus.heater.component import COMPONENT as HEATER
from warmlink.fmus.packaging.native import compile as compiling
from warmlink.fmus.packaging.native.compile import (
    PLATFORMS,
    SMALL_PLATFORMS,
    Compiler,
    compilers,
    host_platform,
    platforms_named,
    universal_binary,
)
from warmlink.fmus.packaging.native.fmu import FmiVersion, header_folder, native_fmu_files, native_sources
from warmlink.orchestration.check.fmu import validity_problems

from .conftest import BuildNative

COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", COMPONENTS)
def test_validation_finds_nothing(name: str, version: FmiVersion, native_fmu: BuildNative) -> None:
    path = native_fmu(name, version)
    assert validity_problems(path) == []
    simulation = read_model_description(str(path)).coSimulation
    continuous = not COMPONENTS[name].sampled
    assert simulation.canInterpolateInputs == (continuous and version == "2.0")
    assert simulation.providesIntermediateUpdate == (continuous and version == "3.0")
    assert simulation.maxOutputDerivativeOrder == int(continuous)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_library_exports_fmi_alone_and_needs_the_c_library_alone(
    version: FmiVersion, native_fmu: BuildNative, c_compiler: Compiler, tmp_path: Path
) -> None:
    if c_compiler.platform.suffix != ".so":
        pytest.skip("read from ELF files")
    with ZipFile(native_fmu("DriftCamera", version)) as archive:
        (name,) = (each for each in archive.namelist() if each.startswith("binaries/"))
        (tmp_path / "library.so").write_bytes(archive.read(name))
    defined, undefined = elf_symbols((tmp_path / "library.so").read_bytes())
    assert f"fmi{version[0]}DoStep" in defined
    assert [each for each in defined if not each.startswith("fmi")] == []
    # Nothing of Python or of CasADi's library.
    allowed = r"[a-z_]\w*|_ITM_\w+|__\w+"
    assert [
        each for each in undefined if not re.fullmatch(allowed, each) or "Py" in each or "casadi" in each
    ] == []


def elf_symbols(content: bytes) -> tuple[list[str], list[str]]:
    """Names that a 64-bit ELF library defines and asks for (its .dynsym)."""
    start = struct.unpack_from("<Q", content, 40)[0]
    size, count = struct.unpack_from("<HH", content, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", content, start + i * size) for i in range(count)]
    (dynamic,) = (each for each in sections if each[1] == 11)
    strings = sections[dynamic[6]][4]
    defined, undefined = [], []
    for place in range(dynamic[4] + 24, dynamic[4] + dynamic[5], 24):
        name, _, _, section = struct.unpack_from("<IBBH", content, place)
        text = content[strings + name :].split(b"\0")[0].decode()
        (defined if section else undefined).append(text)
    return defined, undefined


def test_no_variable_is_shared_between_instances(c_compiler: Compiler, tmp_path: Path) -> None:
    """Objects hold code and constants, no data that could be written."""
    sources, _ = native_sources(COMPONENTS["DriftCamera"], "2.0")
    for name, text in sources.items():
        (tmp_path / name).write_text(text)
        assert not re.search(r"^static (?!const|inline)[^()]*;", text, re.MULTILINE), name
    units = [name for name in sources if name.endswith(".c")]
    command = [*c_compiler.command, "-std=c99", "-I.", f"-I{header_folder()}", "-c", *units]
    subprocess.run(command, cwd=tmp_path, check=True)
    sizes = subprocess.run(
        ["size", *(unit.replace(".c", ".o") for unit in units)], cwd=tmp_path, capture_output=True, text=True
    )
    if sizes.returncode != 0:
        pytest.skip("no `size` on this machine")
    for line in sizes.stdout.splitlines()[1:]:
        assert int(line.split()[2]) == 0, line


@pytest.mark.parametrize("name", COMPONENTS)
def test_an_instance_takes_less_than_64_kib(name: str, c_compiler: Compiler, tmp_path: Path) -> None:
    sources, _ = native_sources(COMPONENTS[name], "3.0")
    for file, text in sources.items():
        (tmp_path / file).write_text(text)
    limit = "typedef char fits[sizeof(Model) < 65536 - 512 ? 1 : -1];"
    (tmp_path / "fits.c").write_text(f'#include "model.h"\n{limit}\n')
    subprocess.run([*c_compiler.command, "-std=c99", "-fsyntax-only", "fits.c"], cwd=tmp_path, check=True)


@pytest.mark.parametrize("version", VERSIONS)
def test_any_tool_can_recompile_the_sources_inside(
    version: FmiVersion, native_fmu: BuildNative, c_compiler: Compiler, tmp_path: Path
) -> None:
    """From what the FMU says of its sources, with strict C99 and all warnings."""
    with ZipFile(native_fmu("MotorHeatSource", version)) as archive:
        archive.extractall(tmp_path)
    description = read_model_description(str(tmp_path))
    listed = description.buildConfigurations[0].sourceFileSets[0].sourceFiles
    command = [
        *c_compiler.command,
        "-std=c99",
        "-pedantic-errors",
        "-Wall",
        "-Wextra",
        "-Werror",
    ]
    done = subprocess.run(
        [*command, "-fPIC", "-shared", f"-I{header_folder()}", *listed, "-o", "again.so", "-lm"],
        cwd=tmp_path / "sources",
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert f"fmi{version[0]}DoStep".encode() in (tmp_path / "sources" / "again.so").read_bytes()


@pytest.mark.parametrize("version", VERSIONS)
def test_optimised_sources_have_no_warning_either(
    version: FmiVersion, c_compiler: Compiler, tmp_path: Path
) -> None:
    """A table's rows, which an optimising compiler follows; FMI's own header declares callbacks by ()."""
    sources, _ = native_sources(COMPONENTS["RecordedDuty"], version)
    for file, text in sources.items():
        (tmp_path / file).write_text(text)
    strict = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wstrict-prototypes", "-Werror"]
    units = [file for file in sources if file.endswith(".c")]
    done = subprocess.run(
        [*c_compiler.command, *strict, f"-I{header_folder()}", "-c", *units],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]


def test_components_can_be_linked_into_one_program(c_compiler: Compiler, tmp_path: Path) -> None:
    """With the standard's prefix, two FMUs have no name in common (FMPy's header of FMI 2.0 knows none)."""
    objects = []
    for name in ("Heater", "NoCompensator"):
        folder = tmp_path / name
        folder.mkdir()
        sources, _ = native_sources(COMPONENTS[name], "3.0")
        for file, text in sources.items():
            (folder / file).write_text(text)
        units = [file for file in sources if file.endswith(".c")]
        prefix = [f"-DFMI3_FUNCTION_PREFIX={name}_"]
        command = [*c_compiler.command, "-std=c99", "-I.", f"-I{header_folder()}", *prefix, "-c", *units]
        subprocess.run(command, cwd=folder, check=True)
        objects += [f"{name}/{unit[:-2]}.o" for unit in units]
    (tmp_path / "main.c").write_text(
        "void *Heater_fmi3DoStep(), *NoCompensator_fmi3DoStep();\n"
        "int main(void) { return !(Heater_fmi3DoStep && NoCompensator_fmi3DoStep); }\n"
    )
    done = subprocess.run(
        [*c_compiler.command, "-w", "main.c", *objects, "-o", "both", "-lm"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]


def test_the_same_sources_give_the_same_bytes(c_compiler: Compiler) -> None:
    (entry,) = (each for each in catalogue() if each.component.name == "Heater")
    once = native_fmu_files(entry, "2.0", [c_compiler])
    compiling._object.cache_clear()
    assert native_fmu_files(entry, "2.0", [c_compiler]) == once


def test_without_any_compiler_the_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiling.shutil, "which", lambda name: None)
    real = importlib.util.find_spec
    monkeypatch.setattr(
        compiling.importlib.util, "find_spec", lambda name: None if name == "ziglang" else real(name)
    )
    host = host_platform()
    assert host is not None
    with pytest.raises(
        InputError, match=r"no C compiler here: install one .* or pip install \"warmlink\[cross\]\""
    ):
        compilers([host])
    other = next(each for each in PLATFORMS.values() if each != host)
    with pytest.raises(
        InputError, match=rf"building for {other.name} needs zig: pip install \"warmlink\[cross\]\""
    ):
        compilers([other])


def test_without_zig_the_machine_compiles_for_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "my-cc -m64")
    monkeypatch.setattr(compiling.importlib.util, "find_spec", lambda name: None)
    (found,) = compilers(platforms_named(None))
    assert found.command == ("my-cc", "-m64")


def test_a_compiler_that_fails_is_quoted(tmp_path: Path) -> None:
    host = host_platform()
    assert host is not None
    with pytest.raises(InputError, match=r"cc: cannot compile for .*: .*error"):
        Compiler(("cc",), host).library({"bad.c": "int f(void) { return nothing; }\n"}, "bad")


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        ("vax-vms", "vax-vms: no such platform; choose x86_64-linux"),
        ("x86_64-linux,", ": no such platform"),
    ],
)
def test_an_unknown_platform(asked: str, answer: str) -> None:
    with pytest.raises(InputError, match=answer):
        platforms_named(asked)


def test_platforms_by_name() -> None:
    assert [each.name for each in platforms_named("x86_64-windows,aarch64-linux")] == [
        "x86_64-windows",
        "aarch64-linux",
    ]
    assert platforms_named("all") == tuple(PLATFORMS.values())


def test_a_universal_binary_holds_its_libraries_at_page_boundaries() -> None:
    first = struct.pack("<III", 0xFEEDFACF, 0x01000007, 3) + b"x" * 100
    second = struct.pack("<III", 0xFEEDFACF, 0x0100000C, 0) + b"y" * 20000
    both = universal_binary([first, second])
    assert struct.unpack_from(">II", both) == (0xCAFEBABE, 2)
    for i, library in enumerate((first, second)):
        processor, _, start, size, power = struct.unpack_from(">IIIII", both, 8 + 20 * i)
        assert both[start : start + size] == library
        assert start % 2**power == 0
        assert processor == struct.unpack_from("<I", library, 4)[0]
    with pytest.raises(ValueError, match="thin"):
        universal_binary([b"\x7fELF" + bytes(20)])


@pytest.mark.parametrize("platform", [*PLATFORMS, *SMALL_PLATFORMS])
def test_what_stands_beside_a_library_is_there_also_where_zig_is_not(
    platform: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object())
    for found in compilers([(PLATFORMS | SMALL_PLATFORMS)[platform]]):
        assert all((compiling._SOURCES / name).is_file() for name in found.beside)
        assert bool(found.beside) == platform.endswith("-windows")


def test_what_is_compiled_for_a_browser_asks_nothing_of_it() -> None:
    pytest.importorskip("ziglang", reason="zig is not installed: pip install 'warmlink[cross]'")
    from warmlink.fmus.packaging.native.fmu import browser_module

    module = browser_module(HEATER)
    assert module[:8] == b"\0asm\1\0\0\0"
    assert 2 not in sections(module), "it imports functions, which a page would have to give it"


def sections(module: bytes) -> list[int]:
    """Numbers of the sections of a WebAssembly module; that of imports is 2."""
    found, place = [], 8
    while place < len(module):
        found.append(module[place])
        size, shift, place = 0, 0, place + 1
        while True:
            byte = module[place]
            size |= (byte & 0x7F) << shift
            shift, place = shift + 7, place + 1
            if not byte & 0x80:
                break
        place += size
    return found
