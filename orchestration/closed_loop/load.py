"""Reading scenarios: shipped ones by name, and files of the user.

A scenario file either names a shipped duty cycle, `duty = "shift_with_breaks"`, or contains a duty cycle in
the form of the duty cycle files. Every duty cycle can also be run as a scenario, with the default settings.
`system` names another system than the warm-up cell: `SixAxisArm`, whose segments have six values each
(`arm/program.py`), or the path of an SSP, for which `[roles]` says which inputs are driven, what is scored
and which instance is the controller (`machine/read.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.machine.read import NamedMachine, RolesTable, machine_in
from warmlink.orchestration.machine.shipped import machine_named, machines
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Drive
from warmlink.orchestration.scenarios.duties.duty_files import DutyTables
from warmlink.orchestration.scenarios.scenario import Scenario, Settings
from warmlink.orchestration.shell import command
from warmlink.orchestration.system.assemble import path_and_variant
from warmlink.orchestration.text_files import absent, is_file, read_text, tables_of
from warmlink.orchestration.written.entries import Names, OneOf, Quantity, Text
from warmlink.orchestration.written.tables import read_table

LIBRARY = Path(__file__).parent / "library"


@dataclass(frozen=True, kw_only=True)
class ScenarioFile(DutyTables, Settings):
    """A scenario: a system, what drives it, what is scored, and how it is run."""

    duty: Annotated[str | None, Text("shift_with_breaks")] = None
    linear: Annotated[tuple[str, ...], Names("ambient_temperature")] = ()
    columns: Mapping[str, Annotated[str, OneOf(duty_files.COLUMNS)]] = field(default_factory=dict)
    stop_time: Annotated[float | None, Quantity("s", positive=True)] = None
    roles: RolesTable | None = None

    def __post_init__(self) -> None:
        if self.duty is None:
            if self.stop_time is None:
                raise InputError('stop_time is missing; write stop_time = "2 h"')
            super().__post_init__()
            for key in ("linear", "columns"):
                if getattr(self, key):
                    told = f'{key}: is of a recorded duty; name one, as duty = "shift.csv"'
                    raise InputError(f"{told}, or leave it out")
            return
        for key in ("segment", "random", "repeat", "reason"):
            if getattr(self, key):
                raise InputError(f"{key} beside duty; name a duty cycle or write one, not both")

    def drive(self, name: str, folder: Path) -> Drive:
        """The duty cycle that the file contains or names; raises InputError if no cycle has that name."""
        if self.duty is None:
            return self.duties(name, self.stop_time or 0.0, (name,))[0]
        beside = folder / self.duty
        source = str(beside) if Path(self.duty).suffix and is_file(beside) else self.duty
        found = duty_files.load(source, self.linear, self.columns)
        return found if self.stop_time is None else found.until(self.stop_time)


_OTHERS = {
    ".ssp": ("a system", "simulate"),
    ".fmu": ("an FMU", "check"),
    ".ssv": ("a parameter set", "run", "--parameters"),
}
"""Files of other types by their ending: what each is, and the command that reads it."""


def scenario_names() -> list[str]:
    """Names of the shipped scenarios, which include the duty cycles and the arm's programs."""
    return sorted({*_shipped(), *duty_files.names()})


def names_on(system: str) -> list[str]:
    """Names of the scenarios in which controllers can be compared, by the system's name."""
    return sorted(path.stem for path in (LIBRARY / system).glob("*.toml")) or duty_files.names()


def _shipped() -> dict[str, Path]:
    return {path.stem: path for path in LIBRARY.rglob("*.toml")}


def load_scenario(name: str, variant: str | None = None) -> Scenario:
    """Load a shipped scenario by its name, or a scenario from a TOML or CSV file by its path.

    A `variant` is the system to take of several in the SSP that the file names. Raises InputError if no
    scenario has that name, the file contains no scenario, or its system has no variants.
    """
    path, shipped = path_given("scenario", name), _shipped()
    ending = path.suffix.lower()
    if variant is not None and ending != ".toml":
        raise InputError(f"{argument('variant', variant)}: {name} names no SSP; leave the variant out")
    if name in shipped:
        return read_scenario(name, read_text(shipped[name], ""))
    if ending == ".toml":
        tables = tables_of(read_text(path, "give an existing .toml, .csv or .parquet"), path.stem)
        return replace(of_tables(path.stem, _in_variant(tables, variant), path.parent), file=path)
    if ending in duty_files.RECORDED_IN or name in duty_files.names():
        duty = duty_files.load(name)
        return Scenario(duty.name, duty.title, duty.reason, duty)
    if ending in _OTHERS and is_file(path):
        what, *words = _OTHERS[ending]
        raise InputError(f"{name}: is no scenario; it is {what}: {command('warmlink', *words, path)}")
    known_names = instead(name, scenario_names(), "or give a TOML or CSV file")
    raise absent(path, known_names, "scenario")


def _in_variant(tables: Mapping[str, Any], variant: str | None) -> Mapping[str, Any]:
    """The tables of a scenario with another variant of its system; InputError if that is no SSP."""
    if variant is None:
        return tables
    path, _ = path_and_variant(str(tables.get("system", "")))
    if not path.lower().endswith(".ssp"):
        told = "the scenario's system is no SSP; leave the variant out"
        raise InputError(f"{argument('variant', variant)}: {told}")
    return {**tables, "system": f"{path}#{variant}"}


def driven(cell: Scenario, duty: Scenario) -> Scenario:
    """The scenario `cell`, driven by the duty cycle of the scenario `duty`.

    Raises InputError if the two are scenarios of different systems.
    """
    takes = {each.machine.name if each.machine.program else "" for each in (cell, duty)}
    if len(takes) > 1:
        raise InputError(
            f"{duty.name}: is made for {duty.machine.name}, but {cell.name} is a scenario of "
            f"{cell.machine.name}; choose another duty cycle"
        )
    return replace(cell, name=duty.name, title=duty.title, about=duty.about, duty=duty.duty)


def read_scenario(name: str, text: str, folder: Path = Path()) -> Scenario:
    """Read a scenario from the text of its file; raises as `of_tables`."""
    return of_tables(name, tables_of(text, name), folder)


def of_tables(name: str, table: Mapping[str, Any], folder: Path = Path()) -> Scenario:
    """Scenario from the tables of its file, the paths in which are relative to `folder`.

    Raises InputError if the file contains no scenario.
    """
    called = str(table.get("system"))
    if called in machines() and (program := machine_named(called).program):
        scenario: Scenario = program(table, name, folder)
        return scenario
    read = read_table(ScenarioFile, table, name)
    drive = read.drive(name, folder)
    machine = machine_in(NamedMachine(read.system, read.roles, name, folder))
    # Several scenarios may name the same duty cycle: its title alone would not distinguish them.
    title = f"{name} · {drive.title}" if read.duty else drive.title
    about = f"Duty cycle {drive.name}: {drive.reason}" if read.duty else drive.reason
    return read.applied(Scenario(name, title, about, drive, machine), folder)
