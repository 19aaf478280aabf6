"""Reading scenarios: those shipped by name, and files of one's own.

A scenario file names a shipped duty cycle, `duty = "shift_with_breaks"`, or holds one of its own in the form
of the duty cycle files. Every duty cycle is a scenario too, with the default settings. `system` names
another system than the warm-up cell: `SixAxisArm`, whose segments hold six values each (`arm/program.py`),
or the path of an SSP, whose `[roles]` say what is driven, what is scored and who controls (`own_system.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from warmlink.controllers.interface import SENSED
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arm.library import NAME as ARM
from warmlink.orchestration.arm.library import PROGRAMS, program_names
from warmlink.orchestration.catalogue import shipped
from warmlink.orchestration.own_law import controller_named
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Duty, Segment
from warmlink.orchestration.scenarios.own_system import own_setup
from warmlink.orchestration.scenarios.quantity import positive, quantity
from warmlink.orchestration.scenarios.scenario import Drive, Scenario
from warmlink.orchestration.scenarios.setup import CELL, Sensors, Setup
from warmlink.orchestration.text_files import (
    is_file,
    known_entries,
    read_text,
    shortened,
    shown,
    tables_of,
    text_entry,
)

LIBRARY = Path(__file__).parent / "library"

_SETTINGS = {
    "title",
    "about",
    "duty",
    "system",
    "roles",
    "stop_time",
    "step_size",
    "master",
    "controller",
    "tolerance",
    "parameters",
    "sensors",
}

_OTHERS = {
    ".ssp": "it is a system: warmlink simulate {}",
    ".fmu": "it is an FMU: warmlink check {}",
    ".ssv": "it is a parameter set: warmlink run --parameters {}",
}
"""What to do with files that are no scenario, by their ending."""

ARM_CONTROLLER, ARM_TOLERANCE = "observer", 30e-6
"""Defaults of the arm's scenarios."""


def scenario_names() -> list[str]:
    """Names of the scenarios that warmlink ships, its duty cycles and the arm's programs among them."""
    return sorted(_shipped() | set(duty_files.names()) | set(program_names()))


def names_on(system: str) -> list[str]:
    """Names of the scenarios that one may compare controllers on, by the system's name."""
    return program_names() if system == ARM else duty_files.names()


def _shipped() -> set[str]:
    return {path.stem for path in LIBRARY.glob("*.toml")}


def load_scenario(name: str) -> Scenario:
    """Scenario by the name of a shipped one, or by the path of a TOML or CSV file.

    Raises
    ------
    InputError
        If there is none of that name, or the file does not hold a scenario.
    """
    path = Path(name)
    for known, folder in ((_shipped(), LIBRARY), (program_names(), PROGRAMS)):
        if name in known:
            return read_scenario(name, read_text(folder / f"{name}.toml", ""))
    if path.suffix == ".toml":
        return read_scenario(path.stem, read_text(path, "give an existing .toml or .csv"), path.parent)
    if path.suffix == ".csv" or name in duty_files.names():
        return _driven_by(duty_files.load(name))
    if path.suffix in _OTHERS and is_file(path):
        raise InputError(f"{name}: is no scenario; {_OTHERS[path.suffix].format(name)}")
    raise InputError(
        f"{shortened(name)}: no such scenario; "
        f"{instead(name, scenario_names(), 'or give a TOML or CSV file')}"
    )


def read_scenario(name: str, text: str, folder: Path = Path()) -> Scenario:
    """Scenario from the text of its file; files that it names are looked for in `folder`.

    Raises
    ------
    InputError
        If the text does not hold one.
    """
    return of_tables(name, tables_of(text, name), folder)


def of_tables(name: str, table: Mapping[str, Any], folder: Path = Path()) -> Scenario:
    """Scenario from the tables of its file; raises as `read_scenario`."""
    setup, default = _setup(name, table, folder)
    known_entries(table, _SETTINGS | _drive_keys(setup), name)
    scenario = replace(default, duty=_drive(name, table, setup, folder), setup=setup)
    # A duty cycle that others follow too does not tell this scenario from theirs.
    title = f"{name} · {scenario.duty.title}" if "duty" in table else scenario.duty.title
    return replace(
        scenario,
        name=name,
        title=text_entry(table, "title", title, name),
        about=text_entry(table, "about", scenario.duty.reason, name),
        step_size=positive(table.get("step_size", scenario.step_size), "s", f"{name}: step_size"),
        master=text_entry(table, "master", scenario.master, name),
        controller=controller_named(text_entry(table, "controller", scenario.controller.name, name)),
        tolerance=positive(table.get("tolerance", scenario.tolerance), "m", f"{name}: tolerance"),
        parameters=written_parameters(name, table),
        sensors=_sensors(name, table.get("sensors", {})),
    )


def _setup(name: str, table: Mapping[str, Any], folder: Path) -> tuple[Setup, Scenario]:
    """The system, and a scenario with its defaults."""
    idle = Duty(name, name, "", 1.0, (Segment(1.0),))
    default = Scenario(name, name, "", idle)
    system = text_entry(table, "system", CELL.name, name)
    if system != CELL.name and "roles" in table and not system.endswith(".ssp"):
        raise InputError(f"{name}: roles: {system} is shipped with its roles; leave the table out")
    if system == CELL.name:
        return CELL, default
    if system == ARM:
        from warmlink.orchestration.arm.setup import arm

        return arm(), replace(default, controller=shipped(ARM_CONTROLLER), tolerance=ARM_TOLERANCE)
    if system.endswith(".ssp"):
        return own_setup(folder / system, table.get("roles", {}), name), default
    raise InputError(f"{name}: system: {instead(system, (CELL.name, ARM), 'or give the path of an SSP')}")


def _drive_keys(setup: Setup) -> frozenset[str] | set[str]:
    if setup.name != ARM:
        return duty_files.KEYS
    from warmlink.orchestration.arm.program import KEYS

    return KEYS


def _driven_by(duty: Duty) -> Scenario:
    return Scenario(duty.name, duty.title, duty.reason, duty)


def _drive(name: str, table: Mapping[str, Any], setup: Setup, folder: Path) -> Drive:
    own = {key: value for key, value in table.items() if key in _drive_keys(setup)}
    if setup.name == ARM:
        from warmlink.orchestration.arm.program import parsed

        return parsed(own, name)
    if "duty" not in table:
        return duty_files.parsed(own, name)
    twice = sorted({"segment", "random", "repeat"} & set(own))
    if twice:
        raise InputError(f"{name}: {twice[0]} beside duty; name a duty cycle or write one, not both")
    named = text_entry(table, "duty", "", name)
    beside = folder / named
    duty = duty_files.load(str(beside) if Path(named).suffix and is_file(beside) else named)
    if "stop_time" in table:
        duty = duty.until(positive(table["stop_time"], "s", f"{name}: stop_time"))
    return duty


def _sensors(name: str, table: Any) -> Sensors:
    """What the table `sensors` says: `noise`, and `used`, the temperatures that designs go by."""
    where = f"{name}: sensors"
    known_entries(table, {"noise", "used"}, where)
    noise = _noise(table["noise"], f"{where}.noise") if "noise" in table else None
    used = table.get("used")
    if used is None:
        return Sensors(noise)
    short = [each.removesuffix("_temperature") for each in SENSED]
    if not isinstance(used, list) or not used:
        raise InputError(f'{where}.used: is no list of temperatures; write used = ["base", "tip"]')
    for each in used:
        if each not in short:
            raise InputError(f"{where}.used: {shown(each)} is not measured; {instead(str(each), short)}")
    return Sensors(noise, tuple(used))


def _noise(text: Any, where: str) -> float:
    value = quantity(text, "K", where, difference=True)
    if value < 0:
        raise InputError(f"{where}: {value:g} K is negative; give the standard deviation of a reading")
    return value


def written_parameters(name: str, table: Mapping[str, Any]) -> dict[str, str | float]:
    """Start values of a scenario file as they are written, by `instance.variable`.

    Raises
    ------
    InputError
        If they are no table, or a name in it is a table again, as TOML takes a name with a dot.
    """
    parameters = table.get("parameters", {})
    if not isinstance(parameters, dict):
        raise InputError(f"{name}: parameters is not a table; write [parameters] above them")
    for key, value in parameters.items():
        if isinstance(value, dict):
            inner = next(iter(value), "length")
            raise InputError(f'{name}: {key}: put the whole name in quotes, as "{key}.{inner}" = "..."')
    return dict(parameters)
