"""C to shared libraries: with this machine's compiler for itself, with zig for every platform."""

import importlib.util
import os
import platform as machine
import re
import shlex
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.files import scratch_folder
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.library import FLAGS


@dataclass(frozen=True)
class Platform:
    """A platform that FMUs are built for: its folders in FMI 3.0, by which it is named, and in FMI 2.0.

    The target is what zig calls it; the flags are for its compiler alone.
    """

    name: str
    fmi2: str
    target: str
    flags: tuple[str, ...] = ()

    @property
    def suffix(self) -> str:
        """What the name of a shared library ends with."""
        system = self.name.partition("-")[2]
        return {"linux": ".so", "windows": ".dll", "darwin": ".dylib", "wasi": ".wasm"}[system]


def _by_name(*platforms: Platform) -> dict[str, Platform]:
    return {each.name: each for each in platforms}


PLATFORMS = _by_name(
    Platform("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17"),
    Platform("aarch64-linux", "aarch64-linux", "aarch64-linux-gnu.2.17"),
    Platform("x86_64-windows", "win64", "x86_64-windows-gnu"),
    Platform("x86_64-darwin", "darwin64", "x86_64-macos.11.0"),
    Platform("aarch64-darwin", "darwin64", "aarch64-macos.11.0"),
)
"""Platforms by name. FMI 2.0 has one folder for macOS; the library in it holds both architectures."""

_SSE2 = ("-msse2", "-mfpmath=sse")  # the x87 computes with more digits, and so other numbers

SMALL_PLATFORMS = _by_name(
    Platform("x86-linux", "linux32", "x86-linux-gnu.2.17", _SSE2),
    Platform("x86-windows", "win32", "x86-windows-gnu", _SSE2),
    Platform("aarch32-linux", "aarch32-linux", "arm-linux-gnueabihf.2.17"),
)
"""Platforms of 32 bits, which are built where they are named: Linux, Windows, and ARM with hard floats."""

BROWSER = Platform("wasm32-wasi", "", "wasm32-wasi")
"""Browsers, which run no FMUs but WebAssembly."""

_SOURCES = Path(__file__).parent / "sources"

_FEW_BRANCHES = ("-fno-gcse", "-fno-tree-vrp")
"""Leaves out of an optimisation what finds next to nothing in this code, and takes long."""

UNIT_FLAGS: Mapping[str, tuple[str, ...]] = {
    "starting.c": ("-O0",),  # large, and run once for each instance: not worth any optimisation
    # What one function stores number by number, another one would read in pairs, and wait for both.
    "running.c": ("-fno-tree-slp-vectorize", *_FEW_BRANCHES),
    # Straight lines, as fast as with -O1, and compiled in two thirds of the time.
    **dict.fromkeys(("deriving.c", "equations.c"), ("-Og",)),
    "fmi2_cs.c": _FEW_BRANCHES,
    "fmi3_cs.c": _FEW_BRANCHES,
    # A log has too few rows for more to be worth its time: -O2 takes twice as long.
    "replay.c": ("-Og",),
    # No part of any step.
    **dict.fromkeys(("model_life.c", "model_sentences.c", "fmi2_rest.c", "fmi3_rest.c"), ("-O0",)),
}
"""Flags of units beside those of all."""


_WINDOWS_PARTS = ("convert", "heap", "math", "private", "stdio", "string")

_WINDOWS_RUNTIME = (
    *("-nostdlib", "-rtlib=compiler-rt"),
    *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in _WINDOWS_PARTS),
    "-lkernel32",
)
"""Links with the C runtime of Windows itself (10 and newer), beside which `windows.c` stands.

MinGW's, which zig takes otherwise, it compiles first: that takes 160 s of a core, and 90 s for 32 bits.
"""


@dataclass(frozen=True)
class Compiler:
    """A C compiler that makes a shared library for one platform, with flags to compile.

    `runtime` is what its libraries are linked with, `beside` the C files here that stand in each of them.
    """

    command: tuple[str, ...]
    platform: Platform
    flags: tuple[str, ...] = FLAGS
    runtime: tuple[str, ...] = ("-lm",)
    beside: tuple[str, ...] = ()

    def library(self, sources: Mapping[str, str], name: str, include: Iterable[Path] = ()) -> bytes:
        """Compile C files to a shared library and return its contents.

        InputError if the compiler fails; its first error stands in the sentence.

        Parameters
        ----------
        sources : texts by file name; those ending in `.c` are compiled
        name : of the library, without its suffix
        include : folders of further headers
        """
        sources = {**sources, **{file: (_SOURCES / file).read_text("utf-8") for file in self.beside}}
        units = [file for file in sources if file.endswith(".c")]
        include, target = tuple(include), name + self.platform.suffix
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = pool.map(lambda unit: _object(self, unit, _needed(unit, sources), include), units)
            compiled = {f"{unit}.o": content for unit, content in zip(units, objects, strict=True)}
        linked = {
            ".so": ["-shared", "-s", "-Wl,--build-id=none", f"-Wl,-soname,{target}"],
            ".dll": ["-shared", "-s"],
            ".dylib": ["-shared", f"-Wl,-install_name,@rpath/{target}"],
            ".wasm": ["-s", "-mexec-model=reactor"],
        }
        arguments = ["-o", target, *linked[self.platform.suffix], *compiled, *self.runtime]
        return self.made(target, compiled, arguments)

    def made(self, target: str, files: Mapping[str, bytes], arguments: Sequence[str]) -> bytes:
        """File that the compiler makes of others, in a folder of their own; InputError if it fails."""
        with scratch_folder() as work:
            for name, content in files.items():
                (work / name).write_bytes(content)
            command = [*self.command, *self.flags, *arguments]
            # What a compiler that is killed leaves goes with the folder.
            own = {**os.environ, "TMPDIR": str(work)}
            done = subprocess.run(
                command, cwd=work, env=own, capture_output=True, text=True, errors="replace"
            )
            if done.returncode == 0:
                return (work / target).read_bytes()
        errors = [line for line in done.stderr.splitlines() if "error" in line.lower()]
        reason = (errors or done.stderr.splitlines() or ["no message"])[0]
        raise InputError(f"{self.command[0]}: cannot compile for {self.platform.name}: {reason.strip()}")


def host_platform() -> Platform | None:
    """Platform of this machine, None where FMUs are not built for it."""
    architecture = machine.machine().lower()
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(architecture, architecture)
    return PLATFORMS.get(f"{architecture}-{machine.system().lower()}")


def platforms_named(names: str | None) -> tuple[Platform, ...]:
    """Platforms of a list such as `x86_64-linux,x86-windows`, or `all` of 64 bits; None is this machine's.

    InputError if a name is unknown, or none is given on a machine of another platform.
    """
    if names is None:
        host = host_platform()
        if host is None:
            raise InputError(
                f"this machine is none of {', '.join(PLATFORMS)}; name the platforms to build for"
            )
        return (host,)
    if names == "all":
        return tuple(PLATFORMS.values())
    known = PLATFORMS | SMALL_PLATFORMS
    unknown = [name for name in names.split(",") if name not in known]
    if unknown:
        raise InputError(f"{unknown[0]}: no such platform; {instead(unknown[0], [*known, 'all'])}")
    return tuple(known[name] for name in dict.fromkeys(names.split(",")))


def compilers(platforms: Sequence[Platform]) -> tuple[Compiler, ...]:
    """A compiler for each platform: zig where it is installed and asked for more than this machine.

    InputError if nothing here compiles for one of them; the sentence says what to install.
    """
    found = os.environ.get("CC") or next(filter(shutil.which, ("cc", "gcc", "clang")), None)
    native = tuple(shlex.split(found)) if found else None
    has_zig = importlib.util.find_spec("ziglang") is not None
    chosen = []
    for platform in platforms:
        ours = platform == host_platform()
        if native is not None and ours and (len(platforms) == 1 or not has_zig):
            chosen.append(Compiler(native, platform))
        elif has_zig:
            # Zig takes our own standard for a guess at the machine's processor unless told otherwise.
            command = (sys.executable, "-m", "ziglang", "cc", "-target", platform.target)
            # It also guards what is not optimised against faults, with a random number that browsers lack.
            guards = ("-fno-sanitize=all", "-fno-stack-protector")
            flags = (*FLAGS, "-mcpu=baseline", *platform.flags, *guards)
            own = (_WINDOWS_RUNTIME, ("windows.c",)) if platform.suffix == ".dll" else ()
            chosen.append(Compiler(command, platform, flags, *own))
        elif ours:
            raise InputError(
                "there is no C compiler here: install one (gcc or clang, as `cc`), "
                'or pip install "warmlink[cross]"'
            )
        else:
            extra = "live" if platform == BROWSER else "cross"
            raise InputError(f'building for {platform.name} needs zig: pip install "warmlink[{extra}]"')
    return tuple(chosen)


def library_here(sources: Mapping[str, str], name: str, *flags: str, level: str | None = None) -> bytes:
    """A shared library for this machine, with further flags; InputError where nothing here compiles it.

    For processors from a `level` on, as `x86-64-v3`, or for any.
    """
    (compiler,) = compilers(platforms_named(None))
    if level is not None:  # zig writes it another way
        flags += (f"-march={level.replace('-', '_') if 'ziglang' in compiler.command else level}",)
    return replace(compiler, flags=(*compiler.flags, *flags)).library(sources, name)


@cache
def _object(
    compiler: Compiler, unit: str, texts: tuple[tuple[str, str], ...], include: tuple[Path, ...]
) -> bytes:
    """Object file of a unit, compiled once for the same texts: both FMI versions share most of theirs."""
    own = UNIT_FLAGS.get(unit, ())
    arguments = ["-I.", *(f"-I{path}" for path in include), *own, "-c", unit, "-o", "unit.o"]

    def compiled() -> bytes:
        return compiler.made("unit.o", {file: text.encode() for file, text in texts}, arguments)

    headers = [header.read_bytes() for path in include for header in sorted(path.glob("*.h"))]
    return kept("objects", (compiler, _version(compiler.command), own, unit, texts, headers), compiled)


@cache
def _version(command: tuple[str, ...]) -> bytes:
    """What a compiler says of its version; zig leaves a file (`a.o`) where it is asked for macOS."""
    with suppress(OSError), scratch_folder() as work:
        return subprocess.run([*command, "--version"], cwd=work, capture_output=True).stdout
    return b""


def _needed(unit: str, sources: Mapping[str, str]) -> tuple[tuple[str, str], ...]:
    """Name and text of a unit and of every file among the sources that it includes."""
    needed: dict[str, str] = {}
    waiting = [unit]
    while waiting:
        file = waiting.pop()
        if file in sources and file not in needed:
            needed[file] = sources[file]
            waiting += re.findall(r'^#include "(.+)"', sources[file], re.MULTILINE)
    return tuple(sorted(needed.items()))


UNIVERSAL, MACH_O_64 = 0xCAFEBABE, 0xFEEDFACF
_ALIGNMENT = 14
"""Power of two; 16 KiB are a page on aarch64, and a multiple of one on x86_64."""


def universal_binary(libraries: Sequence[bytes]) -> bytes:
    """One file of several thin 64-bit Mach-O libraries, one for each architecture of macOS.

    Format: Apple's <mach-o/fat.h> and <mach-o/loader.h>. A table of architectures, big end first, then each
    library at a multiple of its page size. ValueError if one of them is not a thin 64-bit Mach-O file.
    """
    page = 1 << _ALIGNMENT
    head, body = struct.pack(">II", UNIVERSAL, len(libraries)), b""
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_O_64:
            raise ValueError("not a thin 64-bit Mach-O library")
        head += struct.pack(">IIIII", processor, variant, page + len(body), len(library), _ALIGNMENT)
        body += library + bytes(-len(library) % page)
    return head + bytes(page - len(head)) + body
