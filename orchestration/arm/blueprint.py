"""The arm as a system: a motor and a link for each axis in a chain, sensors, compensators and kinematics.

A link's tip warms the next joint through that motor's neighbour port, and what the port takes is taken from
the link's tip. Instances are `axis1.motor`, `axis1.link` and so on, beside `poses` and `kinematics`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from warmlink.fmus.arm_kinematics.equations import AXES
from warmlink.fmus.component.join import Wire
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arm.geometry import NAME, axis
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import System, Value
from warmlink.orchestration.system.shipped import COMPENSATOR, WARMUP_CELL, Blueprint
from warmlink.orchestration.system.write import Ports, write_ssp

ABOUT = "six of duty -> motor <-> link -> sensors -> compensator in a chain, one tool point"

POSES, KINEMATICS = "poses", "kinematics"


def arm_blueprint(count: int = AXES, compensated: bool = True) -> Blueprint:
    """Blueprint of an arm of some axes, each with sensors and a compensator if it is `compensated`.

    Beyond six another arm of six stands on the tip of the one before; InputError for less than one.
    """
    if count < 1:
        raise InputError(f"axes: {count} is not positive; give an arm at least 1 axis")
    axis = WARMUP_CELL.without("camera", *(() if compensated else ("sensors", COMPENSATOR)))
    components: dict[str, str] = {}
    wires: list[Wire] = []
    for i in range(1, count + 1):
        name, place, arm = axis_name(i), (i - 1) % AXES + 1, kinematics_of(i)
        part = axis.prefixed(name)
        components |= part.components
        wires += [
            *part.wires,
            (f"{POSES}.angle[{place}]", f"{arm}.angle[{place}]"),
            (f"{name}.link.elongation", f"{arm}.elongation[{place}]"),
        ]
        if compensated:
            wires.append((f"{name}.{COMPENSATOR}.correction", f"{arm}.correction[{place}]"))
        if i > 1:
            # Heat from a link's tip to the next joint, and back what left it.
            tip, joint = f"{axis_name(i - 1)}.link", f"{name}.motor"
            wires.append((f"{tip}.tip_temperature", f"{joint}.neighbour_temperature"))
            wires.append((f"{joint}.neighbour_heat_flow", f"{tip}.tip_heat_flow"))
    components[POSES] = "PoseSequence"
    components |= dict.fromkeys(map(kinematics_of, range(1, count + 1)), "ArmKinematics")
    called = NAME if count == AXES else f"Arm{count}"
    return Blueprint(called, ABOUT, components, tuple(wires), stop_time=7200.0)


def axis_name(number: int) -> str:
    """Name of the inner system of an axis, numbered from 1."""
    return f"axis{number}"


def kinematics_of(number: int) -> str:
    """Instance of ArmKinematics that an axis belongs to."""
    arm = (number - 1) // AXES
    return KINEMATICS if arm == 0 else f"{KINEMATICS}{arm + 1}"


def arm_values(count: int = AXES, cut: bool = False) -> dict[str, dict[str, Value]]:
    """Start values of motors and links by instance; `cut`: no heat passes from a tip to the next joint."""
    values: dict[str, dict[str, Value]] = {}
    for i in range(1, count + 1):
        values[f"{axis_name(i)}.motor"] = dict(axis(i).motor)
        values[f"{axis_name(i)}.link"] = dict(axis(i).link)
        if cut or i == 1:
            values[f"{axis_name(i)}.motor"]["neighbour_conductance"] = 0.0
    return values


def write_arm(system: System, folder: Path) -> list[Path]:
    """Write an arm as a nested SSP, a flat one, and one with ports, and give their paths.

    Other tools take the flat one, the only one that all of them read; its components bear underscores for
    dots. In the one with ports the duty of each axis and the poses come from outside.
    """
    paths = [folder / f"{system.name}{form}.ssp" for form in ("", "-flat", "-ports")]
    flat = without_dots(system)
    write_ssp(system, paths[0], nested=True)
    write_ssp(flat, paths[1])
    write_ssp(flat, paths[2], _ports(flat))
    return paths


def _ports(arm: System) -> Ports:
    """Duty and angles in; errors of the tool point, elongations, corrections and readings out."""
    wanted = {
        "error": KINEMATICS,
        "elongation": "_link",
        "correction": f"_{COMPENSATOR}",
        "reading": "_sensors",
    }
    shown = tuple(
        (name, variable.name)
        for name, held in arm.components.items()
        for variable in read_description(held.fmu).variables.values()
        if variable.causality == "output"
        and name.endswith(wanted.get(variable.name.partition("[")[0], "nowhere"))
    )
    return Ports((POSES, *(name for name in arm.components if name.endswith("_duty"))), shown)


def without_dots(system: System) -> System:
    """Give the same system with underscores for the dots in its components' names."""
    called = {name: name.replace(".", "_") for name in system.components}
    components = {called[name]: replace(held, name=called[name]) for name, held in system.components.items()}
    links = []
    for link in system.connections:
        giving, taking = called[link.source_component], called[link.target_component]
        links.append(replace(link, source_component=giving, target_component=taking))
    return replace(system, components=components, connections=tuple(links))
