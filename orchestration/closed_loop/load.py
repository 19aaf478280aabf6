"""Reading scenarios: shipped ones by name, and files of the user.

A scenario file either names a shipped duty cycle, `duty = "shift_with_breaks"`, or contains a duty cycle in
the form of the duty cycle files. Every duty cycle can also be run as a scenario, with the default settings.
`system` names another system than the warm-up cell: `SixAxisArm`, whose segments have six values each
(`arm/program.py`), or the path of an SSP, for which `[roles]` says which inputs are driven, what is scored
and which instance is the controller (`scenarios/setup.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arm.blueprint import NAME as ARM
from warmlink.orchestration.arm.blueprint import PROGRAMS, program_names
from warmlink.orchestration.scenarios.duties import duty_files
from warmlink.orchestration.scenarios.duties.duty import Duty
from warmlink.orchestration.scenarios.duties.duty_files import DutyTables
from warmlink.orchestration.scenarios.entries import Quantity, Text
from warmlink.orchestration.scenarios.scenario import Scenario, Settings
from warmlink.orchestration.scenarios.setup import CELL, RolesTable, own_setup
from warmlink.orchestration.scenarios.written import read_table
from warmlink.orchestration.shell import command
from warmlink.orchestration.text_files import absent, is_file, read_text, tables_of

LIBRARY = Path(__file__).parent / "library"


@dataclass(frozen=True, kw_only=True)
class ScenarioFile(DutyTables, Settings):
    """A scenario: a system, what drives it, what is scored, and how it is run."""

    duty: Annotated[str | None, Text("shift_with_breaks")] = None
    stop_time: Annotated[float | None, Quantity("s", positive=True)] = None
    roles: RolesTable | None = None

    def __post_init__(self) -> None:
        if self.duty is None:
            if self.stop_time is None:
                raise InputError('stop_time is missing; write stop_time = "2 h"')
            super().__post_init__()
            return
        for key in ("segment", "random", "repeat"):
            if getattr(self, key):
                raise InputError(f"{key} beside duty; name a duty cycle or write one, not both")

    def drive(self, name: str, folder: Path) -> Duty:
        """The duty cycle that the file contains or names; raises InputError if no cycle has that name."""
        if self.duty is None:
            return self.duties(name, self.stop_time or 0.0, (name,))[0]
        beside = folder / self.duty
        found = duty_files.load(str(beside) if Path(self.duty).suffix and is_file(beside) else self.duty)
        return found if self.stop_time is None else found.until(self.stop_time)


_OTHERS = {
    ".ssp": ("a system", "simulate"),
    ".fmu": ("an FMU", "check"),
    ".ssv": ("a parameter set", "run", "--parameters"),
}
"""What a file that is no scenario is, and the command that reads it, by the file's ending."""


def scenario_names() -> list[str]:
    """Names of the shipped scenarios, which include the duty cycles and the arm's programs."""
    return sorted({*_shipped(), *duty_files.names()})


def names_on(system: str) -> list[str]:
    """Names of the scenarios in which controllers can be compared, by the system's name."""
    return program_names() if system == ARM else duty_files.names()


def _shipped() -> dict[str, Path]:
    return {path.stem: path for folder in (LIBRARY, PROGRAMS) for path in folder.glob("*.toml")}


def load_scenario(name: str) -> Scenario:
    """Load a shipped scenario by its name, or a scenario from a TOML or CSV file by its path.

    Raises InputError if no scenario has that name, or the file contains no scenario.
    """
    path, shipped = Path(name), _shipped()
    if name in shipped:
        return read_scenario(name, read_text(shipped[name], ""))
    if path.suffix == ".toml":
        read = read_scenario(path.stem, read_text(path, "give an existing .toml or .csv"), path.parent)
        return replace(read, file=path)
    if path.suffix == ".csv" or name in duty_files.names():
        duty = duty_files.load(name)
        return Scenario(duty.name, duty.title, duty.reason, duty)
    if path.suffix in _OTHERS and is_file(path):
        what, *words = _OTHERS[path.suffix]
        raise InputError(f"{name}: is no scenario; it is {what}: {command('warmlink', *words, path)}")
    known_names = instead(name, scenario_names(), "or give a TOML or CSV file")
    raise absent(path, known_names, "scenario")


def driven(cell: Scenario, duty: Scenario) -> Scenario:
    """The scenario `cell`, driven by the duty cycle of the scenario `duty`.

    Raises InputError if the two are scenarios of different systems.
    """
    if (cell.setup.name == ARM) != (duty.setup.name == ARM):
        raise InputError(
            f"{duty.name}: is made for {duty.setup.name}, but {cell.name} is a scenario of "
            f"{cell.setup.name}; choose another duty cycle"
        )
    return replace(cell, name=duty.name, title=duty.title, about=duty.about, duty=duty.duty)


def read_scenario(name: str, text: str, folder: Path = Path()) -> Scenario:
    """Read a scenario from the text of its file; raises as `of_tables`."""
    return of_tables(name, tables_of(text, name), folder)


def of_tables(name: str, table: Mapping[str, Any], folder: Path = Path()) -> Scenario:
    """Scenario from the tables of its file, the paths in which are relative to `folder`.

    Raises InputError if the file contains no scenario.
    """
    if table.get("system") == ARM:
        from warmlink.orchestration.arm.program import scenario_of

        return scenario_of(table, name, folder)
    read = read_table(ScenarioFile, table, name)
    drive = read.drive(name, folder)
    setup = CELL
    if read.system.endswith(".ssp"):
        setup = own_setup(folder / read.system, read.roles, name)
    elif read.system != CELL.name:
        raise InputError(
            f"{name}: system: {instead(read.system, (CELL.name, ARM), 'or give the path of an SSP')}"
        )
    elif read.roles is not None:
        raise InputError(f"{name}: roles: {read.system} is shipped with its roles; leave the table out")
    # Several scenarios may name the same duty cycle: its title alone would not distinguish them.
    title = f"{name} · {drive.title}" if read.duty else drive.title
    about = f"Duty cycle {drive.name}: {drive.reason}" if read.duty else drive.reason
    return read.applied(Scenario(name, title, about, drive, setup), folder)
