"""Reading anybody's SSP into the one form that the master runs."""

from __future__ import annotations

import hashlib
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.orchestration.system import archive
from warmlink.orchestration.system.model import Component, System
from warmlink.orchestration.system.ssp.resolve import Resolver
from warmlink.orchestration.system.ssp.ssd import Reader
from warmlink.orchestration.text_files import is_file


def read_system(path: str | Path, workdir: Path | None = None) -> System:
    """Read an SSP of version 1.0 or 2.0, check it against its FMUs and make it flat.

    Parameters
    ----------
    path : the .ssp file, or an .ssd file that lies beside its resources
    workdir : folder into which the SSP is unpacked; the components' FMU files lie there afterwards. By
        default one in warmlink's cache, which stays.

    Returns
    -------
    System
        Components under dotted names; start values and connections in the FMU variables' own units.

    Raises
    ------
    InputError
        If anything is absent, damaged, does not fit or is not supported, with both ends and the reason.
    """
    path = Path(path)
    try:
        return _read(path, _kept(path) if workdir is None else workdir)
    except RecursionError:
        raise InputError(f"{path.name}: nests its systems too deeply; make it flatter") from None


def _kept(path: Path) -> Path:
    """Folder in the cache for the FMUs of a system: runs and studies may need them again."""
    if not is_file(path):
        raise InputError(f"{path}: no such file; give the system as the path of an .ssp")
    folder = cache_folder() / "systems" / hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _read(path: Path, workdir: Path) -> System:
    structure = path
    if path.suffix.lower() != ".ssd":
        folder = archive.unpack(path, workdir)
        if (folder / "modelDescription.xml").is_file():
            raise InputError(
                f"{path.name}: is a single FMU, no system; look at it with `warmlink check {path}`, or run "
                "it as a component of an SSP"
            )
        structure = folder / "SystemStructure.ssd"
    reader = Reader(workdir)
    name, experiment = reader.read(structure)
    if not reader.net.components:
        raise InputError(f"{path.name}: the system {name} has no component; there is nothing to run")
    resolver = Resolver(reader.net, reader.bindings)
    connectors = {place: resolver.connectors(place) for place in reader.net.components}
    connections = tuple(resolver.connections())
    values = resolver.start_values()
    components = {
        full: Component(full, element.fmu, connectors[place], values[place])
        for place, element in reader.net.components.items()
        if (full := ".".join(place)) and element.fmu
    }
    units = dict(sorted(resolver.units.items()))
    return System(name, components, connections, experiment, units, tuple(resolver.remarks))
