"""A component as a native FMU: plain C for FMI 2.0 and FMI 3.0 co-simulation, with its sources inside."""

import hashlib
import importlib.resources
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree as ET

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.attributes import add, document
from warmlink.fmus.packaging.beside import files_beside
from warmlink.fmus.packaging.model_description import instantiation_token, model_description
from warmlink.fmus.packaging.native.codegen import generate, identity_header
from warmlink.fmus.packaging.native.compile import (
    BROWSER,
    Compiler,
    Platform,
    compilers,
    platforms_named,
    universal_binary,
)
from warmlink.fmus.packaging.views import opened

_WRITING = threading.Lock()
"""What works with expressions does so alone: CasADi's options hold for all threads at once."""

FmiVersion = Literal["2.0", "3.0"]

Speaker = FmiVersion | Literal["browser"]
"""Who speaks with the component: a host by one of the standards, or a web page."""

_SOURCES: dict[Speaker, tuple[str, ...]] = {
    "2.0": ("model", "fmi_", "fmi2_"),
    "3.0": ("model", "fmi_", "fmi3_"),
    "browser": ("model", "browser"),
}
"""How the names of the C files begin that each is made of."""


def build_native_fmus(
    entries: Iterable[Entry],
    folder: Path,
    fmi_version: FmiVersion = "2.0",
    platforms: Sequence[Platform] | None = None,
    progress: Callable[[str], None] = lambda name: None,
    arrays: bool = False,
    begun: Callable[[str], None] = lambda name: None,
) -> list[Path]:
    """Write the native FMUs of components and return their paths, in the order of the components.

    InputError if nothing on this machine compiles for a platform, before anything is written.

    Parameters
    ----------
    entries : from `catalogue()`, or of one's own
    folder : where `<Name>.fmu` is written, `dist/native/fmi2`, say
    fmi_version : "2.0" or "3.0"
    platforms : from `platforms_named`; this machine's where none are given
    progress : called with the name of each FMU that is done
    arrays : in FMI 3.0, one variable for an array in place of one for each element
    begun : called with the name of each FMU before it is built
    """
    chosen = compilers(platforms or platforms_named(None))

    def build(entry: Entry) -> Path:
        begun(entry.component.name)
        target = folder / f"{entry.component.name}.fmu"
        write_archive(target, native_fmu_files(entry, fmi_version, chosen, arrays))
        progress(entry.component.name)
        return target

    with ThreadPoolExecutor(2) as pool:
        return [*pool.map(build, entries)]


def native_fmu_files(
    entry: Entry, fmi_version: FmiVersion, chosen: Sequence[Compiler], arrays: bool = False
) -> dict[str, bytes]:
    """Contents of a native FMU by path inside the archive, for the platforms of the compilers chosen."""
    arrays = arrays and fmi_version == "3.0"
    component = opened(entry.component)
    with _WRITING:
        sources, implementation = native_sources(entry.component, fmi_version, arrays)
        units = [name for name in sources if name.endswith(".c")]
        description = model_description(
            component, fmi_version, implementation=implementation, sources=units, arrays=arrays
        )
        beside = files_beside(entry, fmi_version, arrays)
    if fmi_version == "3.0":
        beside["sources/buildDescription.xml"] = _build_description(component, units)
    return {
        "modelDescription.xml": description,
        **beside,
        **_binaries(component, fmi_version, sources, chosen),
        **{f"sources/{name}": text.encode() for name, text in sources.items()},
    }


def native_sources(
    component: Component, speaker: Speaker, arrays: bool = False
) -> tuple[dict[str, str], str]:
    """C files of a component's FMU or web page by name, and the digest that names this implementation.

    A serialised state is taken by an FMU of the same digest alone.
    """
    if speaker != "browser":
        component = opened(component)
    sources = dict(generate(component, arrays))
    folder = importlib.resources.files("warmlink.fmus.packaging.native") / "sources"
    for file in sorted(folder.iterdir(), key=lambda each: each.name):
        if file.name.startswith(_SOURCES[speaker]):
            sources[file.name] = file.read_text(encoding="utf-8")
    digest = hashlib.sha256("\n".join((component.name, *sources.values())).encode()).hexdigest()[:32]
    sources["identity.h"] = identity_header(instantiation_token(component, digest), digest)
    return dict(sorted(sources.items())), digest


def header_folder() -> Path:
    """Folder with the headers of FMI 2.0 and FMI 3.0, which FMPy brings."""
    import fmpy

    return Path(fmpy.__file__).parent / "c-code"


def _binaries(
    component: Component, fmi_version: FmiVersion, sources: dict[str, str], chosen: Sequence[Compiler]
) -> dict[str, bytes]:
    """Libraries by path inside the archive; in FMI 2.0 those of both macOS architectures are one file."""
    libraries: dict[str, list[bytes]] = {}
    for each in chosen:
        platform, library = each.platform, each.library(sources, component.name, [header_folder()])
        folder = platform.fmi2 if fmi_version == "2.0" else platform.name
        libraries.setdefault(f"binaries/{folder}/{component.name}{platform.suffix}", []).append(library)
    return {path: each[0] if len(each) == 1 else universal_binary(each) for path, each in libraries.items()}


def _build_description(component: Component, units: Sequence[str]) -> bytes:
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = add(root, "BuildConfiguration", modelIdentifier=component.name)
    files = add(configuration, "SourceFileSet", language="C99")
    for unit in units:
        add(files, "SourceFile", name=unit)
    add(configuration, "Library", name="m")
    return document(root)


def browser_module(component: Component) -> bytes:
    """Module that imports nothing and exports the functions of `browser.c`.

    Its numbers are the native FMU's to the last bit, except where the two platforms' functions of mathematics
    (logarithm, exponential, sine) round differently. InputError if zig is not installed.
    """
    sources, _ = native_sources(component, "browser")
    (compiler,) = compilers((BROWSER,))
    return compiler.library(sources, component.name)
