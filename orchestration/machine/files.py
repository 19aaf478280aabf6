"""A machine as SSP files: by itself, flat for tools that read no system inside a system, and with ports."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from warmlink.orchestration.system.model import SspVersion, System
from warmlink.orchestration.system.ports import Ports
from warmlink.orchestration.system.write import write_ssp


def write_machine(
    system: System, ports: Ports | None, folder: Path, version: SspVersion = "1.0"
) -> list[Path]:
    """Write a machine's system in every form that it has, and give the paths.

    A system with dots in its instances' names is written with a system inside it for each name before a dot,
    and flat, with underscores for the dots, which all tools read. With `ports` there is one more, in which
    what drives the machine comes from outside. All are of one version of SSP.
    """
    flat = without_dots(system)
    nested = flat.components.keys() != system.components.keys()
    paths = [folder / f"{system.name}.ssp"]
    write_ssp(system, paths[0], nested=nested, version=version)
    if nested:
        paths.append(folder / f"{system.name}-flat.ssp")
        write_ssp(flat, paths[-1], version=version)
    if ports is not None:
        drivers = tuple(_plain(name) for name in ports.drivers)
        shown = tuple((_plain(name), variable) for name, variable in ports.shown)
        paths.append(folder / f"{system.name}-ports.ssp")
        write_ssp(flat, paths[-1], Ports(drivers, shown), version=version)
    return paths


def without_dots(system: System) -> System:
    """The same system with underscores for the dots in its components' names."""
    components = {_plain(name): replace(held, name=_plain(name)) for name, held in system.components.items()}
    links = tuple(
        replace(c, source_component=_plain(c.source_component), target_component=_plain(c.target_component))
        for c in system.connections
    )
    return replace(system, components=components, connections=links)


def _plain(name: str) -> str:
    return name.replace(".", "_")
