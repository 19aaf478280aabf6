"""Systems from files: read from anybody's SSP, or built in code of FMU files, with the same checks."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.component.join import Wire
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed
from warmlink.fmus.packaging.cache import cache_folder
from warmlink.orchestration.system import archive
from warmlink.orchestration.system.check import checked_values, variable_of
from warmlink.orchestration.system.described import described, resized
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import (
    CONNECTOR_KINDS,
    Connection,
    Connector,
    FmuPart,
    StartValues,
    System,
    Value,
)
from warmlink.orchestration.system.ssp.arrays import take_apart
from warmlink.orchestration.system.ssp.net import Net, net_of
from warmlink.orchestration.system.ssp.resolve import Binding, Resolver
from warmlink.orchestration.system.ssp.ssd import Reader, parts_of
from warmlink.orchestration.text_files import demand_file

STRUCTURE = "SystemStructure.ssd"
"""Name of the SSD that an SSP is read from unless a variant is chosen."""


def component(name: str, fmu: Path, values: Mapping[str, Value] | None = None) -> FmuPart:
    """Give a component of a system, with start values in the variables' own units.

    `write_ssp` lists as its connectors the variables that are connected or have a start value, and its
    outputs. InputError if the FMU cannot be read or a value does not fit.
    """
    return FmuPart(
        name, fmu, values=checked_values(resized(read_description(fmu), values or {}), values or {}, name)
    )


def assemble(
    name: str,
    fmus: Mapping[str, str | Path],
    wires: Iterable[Wire] = (),
    values: StartValues = MappingProxyType({}),
) -> System:
    """Make a system of FMU files.

    Parameters
    ----------
    name : what the system is called
    fmus : the .fmu file of each component, by the component's name
    wires : ends of each connection, as `("motor.heat_flow", "link.heat_flow")`; units are converted
    values : start values by component and variable, in the variables' own units

    Raises
    ------
    InputError
        If an FMU cannot be read, or something does not exist or does not fit.

    Examples
    --------
    >>> fmus = wl.fmu_files(["MotorHeatSource", "ThermalLink"])
    >>> parts = {"motor": fmus["MotorHeatSource"], "link": fmus["ThermalLink"]}
    >>> pair = wl.assemble("pair", parts, [("motor.heat_flow", "link.heat_flow")], {"motor": {"speed": 3.0}})
    >>> wl.write_ssp(pair, "pair.ssp")
    """
    for each in values:
        if each not in fmus:
            raise InputError(f"{each}: there is no component of this name; {instead(each, fmus)}")
    parts = {each: component(each, Path(fmu), values.get(each)) for each, fmu in fmus.items()}
    return System(name, parts, connected(parts, wires))


def connected(components: Mapping[str, FmuPart], wires: Iterable[Wire]) -> tuple[Connection, ...]:
    """Give connections between variables of components, with the conversion of their units.

    A component's name may hold dots; a wire given from an input to an output is turned round. InputError if
    an end does not exist, is driven twice, or kinds, types or quantities do not fit.
    """
    links = [Connection(*end_of(components, source), *end_of(components, target)) for source, target in wires]
    used = {name for link in links for name, _ in link.ends}
    ends = {name: replace(components[name], connectors={}) for name in components if name in used}
    return tuple(_resolved(System("", ends, tuple(links))))


def check_system(system: System) -> None:
    """Check a system, read or made in code, against its FMUs; `write_ssp` calls it.

    Raises InputError if a connector, start value or connection does not fit, or an input is driven twice.
    """
    for name, held in system.components.items():
        if name != held.name:
            raise InputError(
                f"{name}: the component under this name is named {held.name}; give both one name"
            )
        checked_values(described(held), held.values, name)
    for link, found in zip(system.connections, _resolved(system), strict=True):
        if found.ends == link.ends[::-1]:
            raise InputError(
                f"{link.source} -> {link.target}: leads from an input to an output; turn it round"
            )
        between = f"{link.source} -> {link.target}"
        if (found.factor, found.offset) != (link.factor, link.offset):
            raise InputError(
                f"{between}: the units differ by a factor {found.factor:g} and an "
                f"offset {found.offset:g}; give them to the connection"
            )
        changed = tuple((given, made) for given, made in link.values if given != made)
        if found.values != changed:
            told = f"one value becomes two others in {changed}"
            raise InputError(f"{between}: {told}; give each value of {link.source} once")


def _resolved(system: System) -> list[Connection]:
    """Give a system's connections with the conversion of their units, as they are when an SSD is read."""
    net = net_of(system)
    ends = [node for edge in net.elements[()].connections for node in edge.ends]
    for node in ends:  # those that their components do not declare as connectors
        element = net.elements.get(node.path)
        if element is not None and element.info is not None and node.connector not in element.connectors:
            causality = variable_of(element.info, node.connector, str(node)).causality
            # The independent variable (time) fits no kind; call it a parameter, so that
            # connecting it is refused.
            kind = causality if causality in CONNECTOR_KINDS else "parameter"
            element.connectors[node.connector] = Connector(kind)
    resolver = Resolver(net)
    for path in net.components:
        resolver.connectors(path)
    return list(resolver.connections())


def owner_of(components: Iterable[str], name: str) -> str:
    """Component whose variable a full name is, empty if none has it.

    Names of components and of variables may both hold dots; of several components the longest name counts.
    """
    return max((each for each in components if name.startswith(f"{each}.")), key=len, default="")


def end_of(components: Mapping[str, FmuPart], name: str, where: str = "") -> tuple[str, str]:
    """Component and variable that a full name means.

    InputError if there is no such component; whether that has the variable is not checked.
    """
    owner = owner_of(components, name)
    if not owner:
        place, known = f"{where}: " if where else "", instead(name, components)
        raise InputError(f"{place}{name}: there is no component of this name; {known}")
    return owner, name[len(owner) + 1 :]


def read_system(path: str | Path, workdir: Path | None = None, variant: str | None = None) -> System:
    """Read an SSP of version 1.0 or 2.0, check it against its FMUs and make it flat.

    Its components then have dotted names; start values and connections are in their variables' own units. A
    single FMU is a system of one component, which bears the file's name.

    Parameters
    ----------
    path : the .ssp file, an .ssd file that lies beside its resources, or an .fmu file
    workdir : folder into which the SSP is unpacked, by default one in warmlink's cache, which stays
    variant : which system, of several in one SSP: the name of its description, as `VarB` for `VarB.ssd`; by
        default `SystemStructure`

    Raises
    ------
    InputError
        If anything is absent, damaged, does not fit or is not supported, with both ends and the reason.

    Examples
    --------
    >>> system = wl.read_system("dist/WarmupCell.ssp")
    >>> wl.simulate(system, "1 h")
    """
    path = path_given("path", path)
    demand_file(path, "give the path of an .fmu or .ssp file")
    if _is_fmu(path):
        refuse_variant(path, variant)
        return _system_of_one(path)
    try:
        return _read(path, _kept(path) if workdir is None else workdir, variant)
    except RecursionError:
        raise InputError(f"{path.name}: nests its systems too deeply; make it flatter") from None


def variants(path: Path) -> list[str]:
    """Names of the systems in an SSP, without those that are parts of another.

    SystemStructure, which is run unless another is chosen, is first if there is one. InputError if the SSP
    cannot be read.
    """
    with archive.open_archive(path) as held:
        found = {name for name in held.namelist() if "/" not in name and name.endswith(".ssd")}
    if len(found) > 1:
        parts = {part for name in found for part in _parts(path, name)}
        found = found - (parts - {STRUCTURE}) or found
    return sorted((Path(name).stem for name in found), key=lambda name: (name != Path(STRUCTURE).stem, name))


def _parts(path: Path, name: str) -> set[str]:
    """Other SSDs that one in an SSP has as components; of one that is damaged none."""
    with suppress(InputError):  # which is said when that one is read
        return parts_of(archive.read_member(path, name), name) - {name}
    return set()


def path_and_variant(system: str) -> tuple[str, str | None]:
    """Split `chain.ssp#VarB` into path and variant, which is None if none is named."""
    path, _, variant = system.rpartition("#")
    return (path, variant) if path.lower().endswith(".ssp") else (system, None)


def refuse_variant(path: Path, variant: str | None) -> None:
    """Raise InputError where a variant is asked of a file that holds none, as an FMU."""
    _refuse_choice(path, variant, ())


def _refuse_choice(path: Path, chosen: str | None, held: Iterable[Path]) -> None:
    names = sorted(each.stem for each in held)
    if chosen is not None and chosen not in names:
        remedy = instead(chosen, names) if names else "leave the variant out"
        raise InputError(f"{argument('variant', chosen)}: no variant of the system in {path.name}; {remedy}")


def _kept(path: Path) -> Path:
    """Folder in the cache for the FMUs of a system: runs and studies may need them again."""
    folder = cache_folder() / "systems" / hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _is_fmu(path: Path) -> bool:
    """Whether a file is an FMU, by its ending or by what the archive holds."""
    if path.suffix.lower() in (".fmu", ".ssd"):
        return path.suffix.lower() == ".fmu"
    with archive.open_archive(path) as held:
        return "modelDescription.xml" in held.namelist()


def _system_of_one(fmu: Path) -> System:
    """The system whose one component, of the file's name, is an FMU."""
    info = read_description(fmu)
    return System(
        info.model_name, {fmu.stem: component(fmu.stem, fmu)}, (), info.default_experiment, info.remarks
    )


def _resize(net: Net, bindings: Sequence[Binding]) -> None:
    """Give arrays the sizes that the bindings of structural parameters mean."""
    for path, values in Resolver(net, bindings).start_values("structuralParameter").items():
        element = net.elements[path]
        if values and element.info is not None:
            info = resized(element.info, values).used_as(element.implementation)
            net.elements[path] = net.components[path] = replace(element, info=info)


def _read(path: Path, workdir: Path, chosen: str | None) -> System:
    structure, remarks, held = path, list[str](), set[Path]()
    chosen = None if chosen is None else chosen.removesuffix(".ssd")
    if path.suffix.lower() != ".ssd":
        remarks += archive.repeated_entries(path)
        folder = archive.unpack(path, workdir)
        structure, held = folder / (f"{chosen}.ssd" if chosen else STRUCTURE), set(folder.glob("*.ssd"))
        if held and chosen is None and structure not in held:
            found = variants(path)
            told = f"holds no {STRUCTURE}, which is read unless a variant is chosen, but {listed(found)}"
            raise InputError(f"{path.name}: {told}; give {argument('variant', found[0])}, for example")
    _refuse_choice(path, chosen, held)
    reader = Reader(workdir, remarks=remarks, unpacked=structure == path)
    name, experiment = reader.read(structure)
    apart = {each.stem for each in held - reader.documents} if chosen is None else set()
    if apart and (others := [each for each in variants(path) if each in apart]):
        told = f"{listed(others)}; {argument('variant', others[0])} runs {others[0]} instead"
        remarks.append(f"{path.name}: {structure.stem} is run, one of several variants; beside it {told}")
    if not reader.net.components:
        raise InputError(f"{path.name}: the system {name} has no component; there is nothing to run")
    for element in reader.net.components.values():
        remarks += element.info.remarks if element.info else ()
    _resize(reader.net, reader.bindings)
    take_apart(reader.net)
    resolver = Resolver(reader.net, reader.bindings, remarks)
    connectors = {place: resolver.connectors(place) for place in reader.net.components}
    connections = tuple(resolver.connections())
    values = resolver.start_values()
    components = {
        full: FmuPart(full, element.fmu, connectors[place], values[place], element.implementation)
        for place, element in reader.net.components.items()
        if (full := ".".join(place)) and element.fmu
    }
    remarks += [
        f"{each.target}: its start value {components[each.target_component].values[each.target_variable]} "
        f"has no effect once the run has begun, since {each.source} feeds it; "
        f"set the parameters of {each.source_component} instead"
        for each in connections
        if each.target_variable in components[each.target_component].values
    ]
    return System(name, components, connections, experiment, tuple(dict.fromkeys(remarks)))
