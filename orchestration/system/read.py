"""Reading anybody's SSP into the one form that the master runs."""

from __future__ import annotations

import hashlib
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.orchestration.system import archive
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Component, System
from warmlink.orchestration.system.ssp.declared import Description
from warmlink.orchestration.system.ssp.flatten import Flat, flatten
from warmlink.orchestration.system.ssp.flatten import Path as ElementPath
from warmlink.orchestration.system.ssp.resolve import Resolver
from warmlink.orchestration.system.ssp.ssd import read_ssd
from warmlink.orchestration.system.ssp.start_values import StartValues
from warmlink.orchestration.system.units import Unit
from warmlink.orchestration.text_files import is_file


def read_system(path: str | Path, workdir: Path | None = None) -> System:
    """Read an SSP of version 1.0 or 2.0, check it against its FMUs and make it flat.

    Parameters
    ----------
    path
        The .ssp file, or an .ssd file that lies beside its resources.
    workdir
        Folder into which the SSP is unpacked; the components' FMU files lie there afterwards. By default one
        in warmlink's cache, which stays.

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
    description = read_ssd(_structure(path, workdir), workdir)
    flat = flatten(description.system)
    if not flat.components:
        raise InputError(
            f"{path.name}: the system {description.name} has no component; there is nothing to run"
        )
    infos = {place: _described(".".join(place), found.fmu) for place, found in flat.components.items()}
    return _assembled(description, flat, infos)


def _structure(path: Path, workdir: Path) -> Path:
    """The .ssd file, unpacked where it is in an SSP."""
    if path.suffix.lower() == ".ssd":
        return path
    folder = archive.unpack(path, workdir)
    if (folder / "modelDescription.xml").is_file():
        raise InputError(
            f"{path.name}: is a single FMU, no system; look at it with `warmlink check {path}`, or run it as "
            "a component of an SSP"
        )
    return folder / "SystemStructure.ssd"


def _assembled(description: Description, flat: Flat, infos: dict[ElementPath, ModelInfo]) -> System:
    resolver = Resolver(flat, infos)
    connectors = {place: resolver.connectors(place) for place in flat.components}
    connections = tuple(resolver.connections())
    start = StartValues(resolver)
    start.collect()
    components = {}
    for place, declared in flat.components.items():
        name = ".".join(place)
        components[name] = Component(name, declared.fmu, connectors[place], start.found[place])
    return System(
        description.name,
        components,
        connections,
        description.default_experiment,
        _units_of_their_own(flat, infos),
        tuple(start.remarks),
    )


def _units_of_their_own(flat: Flat, infos: dict[ElementPath, ModelInfo]) -> dict[str, Unit]:
    """Give the units that connectors use because their FMUs tell none."""
    used = {}
    for place, component in flat.components.items():
        for connector in component.connectors.values():
            unit = connector.unit
            if unit and unit.exponents is not None and infos[place].variables[connector.name].unit is None:
                used[unit.name] = unit
    return dict(sorted(used.items()))


def _described(name: str, fmu: Path) -> ModelInfo:
    try:
        return read_description(fmu)
    except InputError as fault:
        raise InputError(f"{name}: {fault}") from fault
