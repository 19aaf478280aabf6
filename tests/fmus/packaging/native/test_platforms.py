"""Libraries for platforms other than this one: built here, and run in emulators where there are any."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

from warmlink.fmus.catalogue import catalogue
from warmlink.fmus.motor_heat_source.component import COMPONENT
from warmlink.fmus.packaging.native.compile import (
    PLATFORMS,
    SMALL_PLATFORMS,
    Compiler,
    _version,
    compilers,
)
from warmlink.fmus.packaging.native.fmu import FmiVersion, build_native_fmus

from .bare_host import HERE, arguments, compile_host, hour_in_python

pytestmark = [pytest.mark.slow, pytest.mark.platform, pytest.mark.timeout(600)]

NAME = COMPONENT.name
VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")
SYSTEM_ROOT = Path("/usr/aarch64-linux-gnu")


def require_zig() -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('cross-compiling needs zig: pip install "warmlink[cross]"')


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[FmiVersion, Path]:
    """One component for every platform."""
    require_zig()
    (entry,) = (each for each in catalogue() if each.component.name == NAME)
    folder = tmp_path_factory.mktemp("cross")
    everywhere = list(PLATFORMS.values())
    return {
        version: build_native_fmus([entry], folder / version, version, everywhere)[0] for version in VERSIONS
    }


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same component for the platforms of 32 bits, FMI 2.0."""
    require_zig()
    (entry,) = (each for each in catalogue() if each.component.name == NAME)
    folder = tmp_path_factory.mktemp("small")
    return build_native_fmus([entry], folder, "2.0", list(SMALL_PLATFORMS.values()))[0]


def compiler(platform: str) -> Compiler:
    (found,) = compilers([(PLATFORMS | SMALL_PLATFORMS)[platform]])
    if "ziglang" not in found.command:
        # Alone, this machine's platform is compiled by its own compiler.
        found = compilers(list(PLATFORMS.values()))[list(PLATFORMS).index(platform)]
    return found


def library(fmu: Path, version: FmiVersion, platform: str) -> tuple[str, bytes]:
    place = (PLATFORMS | SMALL_PLATFORMS)[platform]
    path = f"binaries/{place.fmi2 if version == '2.0' else place.name}/{NAME}{place.suffix}"
    with ZipFile(fmu) as archive:
        return path, archive.read(path)


@pytest.mark.parametrize("version", VERSIONS)
def test_every_platform_lies_inside(fmus: dict[FmiVersion, Path], version: FmiVersion) -> None:
    with ZipFile(fmus[version]) as archive:
        found = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert found == {p.fmi2 if version == "2.0" else p.name for p in PLATFORMS.values()}


@pytest.mark.parametrize("platform", ["x86_64-linux", "aarch64-linux"])
def test_linux_asks_for_no_newer_glibc_than_2_17(fmus: dict[FmiVersion, Path], platform: str) -> None:
    for version in VERSIONS:
        _, content = library(fmus[version], version, platform)
        asked = {
            tuple(map(int, found.split(b"."))) for found in re.findall(rb"GLIBC_(\d+(?:\.\d+)+)", content)
        }
        assert asked
        assert max(asked) <= (2, 17)


def run_hour(command: list[str], **options: Any) -> list[float]:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, **options)
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-2000:]
    return [float(line) for line in done.stdout.split()][:-1]


def test_a_compiler_that_is_asked_for_its_version_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As zig leaves an empty `a.o` for macOS."""
    require_zig()
    monkeypatch.chdir(tmp_path)
    assert _version.__wrapped__(compiler("aarch64-darwin").command)
    assert list(tmp_path.iterdir()) == []


def run_here(fmu: Path, version: FmiVersion, folder: Path) -> list[float]:
    """An hour on this machine's own processor."""
    if sys.platform != "linux" or os.uname().machine != "x86_64":
        pytest.skip("this machine is not x86_64-linux")
    folder.mkdir()
    host = compile_host(compiler("x86_64-linux"), version, folder)
    path, _ = library(fmu, version, "x86_64-linux")
    return run_hour([str(host), *arguments(COMPONENT, fmu, path, folder / "fmu")])


@pytest.mark.parametrize("version", VERSIONS)
def test_the_oldest_glibc_library_runs_here(
    fmus: dict[FmiVersion, Path], version: FmiVersion, tmp_path: Path
) -> None:
    found = run_here(fmus[version], version, tmp_path / "here")
    assert found == pytest.approx(hour_in_python(COMPONENT), rel=1e-9)


def wine_prefix(folder: Path) -> Path:
    """A Windows with what a console program needs; Wine's own full one takes minutes to make."""
    found = [*Path("/usr/lib").glob("*/wine/x86_64-windows"), *Path("/usr/lib").glob("wine/x86_64-windows")]
    if not found or folder.exists():
        return folder
    system = folder / "drive_c" / "windows" / "system32"
    drives = folder / "dosdevices"
    system.mkdir(parents=True)
    drives.mkdir()
    (drives / "c:").symlink_to("../drive_c")
    (drives / "z:").symlink_to("/")
    for name in ("kernel32", "kernelbase", "ntdll", "ucrtbase", "msvcrt", "advapi32", "sechost"):
        (system / f"{name}.dll").symlink_to(found[0] / f"{name}.dll")
    (folder / ".update-timestamp").write_text("disable")
    return folder


@pytest.mark.parametrize("version", VERSIONS)
def test_windows_library_runs_under_wine(
    fmus: dict[FmiVersion, Path],
    version: FmiVersion,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    wine = shutil.which("wine64") or shutil.which("wine")
    if wine is None:
        pytest.skip("Wine is not installed (Debian: apt-get install wine64)")
    host = compile_host(compiler("x86_64-windows"), version, tmp_path, ".exe", f"-I{HERE / 'windows'}")
    path, _ = library(fmus[version], version, "x86_64-windows")
    given = arguments(COMPONENT, fmus[version], path, tmp_path / "fmu")
    prefix = wine_prefix(tmp_path_factory.getbasetemp() / "wine")
    quiet = {
        **os.environ,
        "WINEPREFIX": str(prefix),
        "WINEDEBUG": "-all",
        "WINEDLLOVERRIDES": "mscoree,mshtml=",
    }
    given[0] = "Z:" + given[0].replace("/", "\\")
    found = run_hour([wine, str(host), *given], env=quiet)
    assert found == pytest.approx(hour_in_python(COMPONENT), rel=1e-9)
    assert found == run_here(fmus[version], version, tmp_path / "here"), "not the same bits"


@pytest.mark.parametrize("version", VERSIONS)
def test_aarch64_library_runs_under_qemu(
    fmus: dict[FmiVersion, Path], version: FmiVersion, tmp_path: Path
) -> None:
    qemu = shutil.which("qemu-aarch64")
    if qemu is None:
        pytest.skip("qemu-user is not installed (Debian: apt-get install qemu-user)")
    if not SYSTEM_ROOT.is_dir():
        pytest.skip("no C library of aarch64 (Debian: apt-get install libc6-arm64-cross)")
    host = compile_host(compiler("aarch64-linux"), version, tmp_path)
    path, _ = library(fmus[version], version, "aarch64-linux")
    given = arguments(COMPONENT, fmus[version], path, tmp_path / "fmu")
    found = run_hour([qemu, "-L", str(SYSTEM_ROOT), str(host), *given])
    assert found == pytest.approx(hour_in_python(COMPONENT), rel=1e-9)
    assert found == run_here(fmus[version], version, tmp_path / "here"), "not the same bits"


def test_32_bit_libraries_run_where_there_is_a_host(small: Path, tmp_path: Path) -> None:
    """On this machine's own processor, and on an emulated ARM."""
    emulated = ("qemu-arm", "-L", "/usr/arm-linux-gnueabihf")
    hosts: dict[str, tuple[Path, tuple[str, ...]]] = {
        "x86-linux": (Path("/lib/ld-linux.so.2"), ()),
        "aarch32-linux": (Path(emulated[-1]), emulated if shutil.which(emulated[0]) else ()),
    }
    ran = []
    for platform, (needed, command) in hosts.items():
        if not needed.exists() or (platform.startswith("aarch") and not command):
            continue
        folder = tmp_path / platform
        folder.mkdir()
        host = compile_host(compiler(platform), "2.0", folder)
        path, _ = library(small, "2.0", platform)
        given = arguments(COMPONENT, small, path, folder / "fmu")
        assert run_hour([*command, str(host), *given]) == pytest.approx(hour_in_python(COMPONENT), rel=1e-9)
        ran.append(platform)
    if not ran:
        pytest.skip("nothing runs 32 bits here (Debian: libc6-i386, or qemu-user and libc6-armhf-cross)")


def test_the_windows_library_of_32_bits_exports_fmi(small: Path) -> None:
    path, content = library(small, "2.0", "x86-windows")
    assert path == f"binaries/win32/{NAME}.dll"
    (machine,) = struct.unpack_from("<H", content, struct.unpack_from("<I", content, 0x3C)[0] + 4)
    assert machine == 0x14C, "not for i386"
    assert b"\0fmi2DoStep\0" in content


def test_windows_libraries_need_what_windows_has_and_no_more(
    fmus: dict[FmiVersion, Path], small: Path
) -> None:
    for _, content in (library(fmus["2.0"], "2.0", "x86_64-windows"), library(small, "2.0", "x86-windows")):
        needed = {name.decode().lower() for name in re.findall(rb"[\w-]+\.dll", content, re.IGNORECASE)}
        others = [name for name in needed - {f"{NAME}.dll".lower()} if not name.startswith("api-ms-win-crt-")]
        assert set(others) <= {"kernel32.dll"}


@pytest.mark.parametrize("version", VERSIONS)
def test_macos_libraries_export_fmi_and_need_the_system_library_alone(
    fmus: dict[FmiVersion, Path], version: FmiVersion
) -> None:
    function = f"_fmi{version[0]}DoStep"
    for platform, processor in (("x86_64-darwin", 0x01000007), ("aarch64-darwin", 0x0100000C)):
        _, content = library(fmus[version], version, platform)
        thin = architectures(content)[processor]
        facts = MachO(thin)
        assert facts.kind == 6, "not a dynamic library"
        assert facts.needs == ["/usr/lib/libSystem.B.dylib"]
        assert facts.name == f"@rpath/{NAME}.dylib"
        assert facts.oldest_system == (11, 0)
        assert function in facts.exports
        # The linker adds __mh_dylib_header and ___dso_handle of its own.
        assert [name for name in facts.exports if not name.startswith(("_fmi", "__"))] == []
        # Apple's processors load signed code only; the linker's own signature will do.
        assert facts.signed or processor != 0x0100000C


def architectures(content: bytes) -> dict[int, bytes]:
    """Thin libraries by processor type."""
    if struct.unpack_from(">I", content)[0] != 0xCAFEBABE:
        return {struct.unpack_from("<I", content, 4)[0]: content}
    found = {}
    for i in range(struct.unpack_from(">I", content, 4)[0]):
        processor, _, start, size, alignment = struct.unpack_from(">IIIII", content, 8 + 20 * i)
        assert start % (1 << alignment) == 0
        found[processor] = content[start : start + size]
    return found


class MachO:
    """What the load commands of a thin 64-bit Mach-O library say (<mach-o/loader.h>, <mach-o/nlist.h>)."""

    def __init__(self, content: bytes) -> None:
        magic, _, _, self.kind, count, _, _, _ = struct.unpack_from("<8I", content)
        assert magic == 0xFEEDFACF
        self.needs: list[str] = []
        self.exports: list[str] = []
        self.signed = False
        place = 32
        for _ in range(count):
            command, size = struct.unpack_from("<II", content, place)
            body = content[place : place + size]
            if command in (0x0C, 0x0D):
                text = body[struct.unpack_from("<I", body, 8)[0] :].split(b"\0")[0].decode()
                if command == 0x0D:
                    self.name = text
                else:
                    self.needs.append(text)
            elif command == 0x32:
                oldest = struct.unpack_from("<I", body, 12)[0]
                self.oldest_system = (oldest >> 16, oldest >> 8 & 255)
            elif command == 0x1D:
                self.signed = True
            elif command == 0x02:
                self.exports = list(self._exports(content, *struct.unpack_from("<IIII", body, 8)))
            place += size

    @staticmethod
    def _exports(content: bytes, symbols: int, count: int, strings: int, size: int) -> list[str]:
        table = content[strings : strings + size]
        found = []
        for i in range(count):
            name, kind, section, _, _ = struct.unpack_from("<IBBHQ", content, symbols + 16 * i)
            external, private, defined = kind & 0x01, kind & 0x10, section != 0
            if external and not private and defined:
                found.append(table[name:].split(b"\0")[0].decode())
        return found


def test_builds_are_the_same_to_the_last_byte(fmus: dict[FmiVersion, Path], tmp_path: Path) -> None:
    # A process of its own has none of this one's objects; zig's own cache is not ours to empty here.
    script = (
        "import sys; from pathlib import Path;"
        "from warmlink.fmus.packaging.native.fmu import *;"
        "from warmlink.fmus.catalogue import catalogue;"
        f"entries = [e for e in catalogue() if e.component.name == {NAME!r}];"
        "build_native_fmus(entries, Path(sys.argv[1]), sys.argv[2], platforms_named('all'))"
    )
    for version in VERSIONS:
        subprocess.run([sys.executable, "-c", script, str(tmp_path / version), version], check=True)
        assert (tmp_path / version / f"{NAME}.fmu").read_bytes() == fmus[version].read_bytes()
