"""Scenarios: a duty cycle, the cell it runs in, and how it is run.

A scenario file names a shipped duty cycle, `duty = "shift_with_breaks"`, or holds one of its own in the form
of the duty cycle files. Every duty cycle is a scenario too, with the default settings.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.scenarios import duty_files
from warmlink.orchestration.scenarios.duty import Duty
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.text_files import (
    is_file,
    known_entries,
    read_text,
    shortened,
    tables_of,
    text_entry,
)

LIBRARY = Path(__file__).parent / "library"

DEFAULT_SCENARIO = "windshield_wiper"
DEFAULT_TOLERANCE = 5e-6
DEFAULT_STEP = 1.0
DEFAULT_MASTER = "gauss_seidel"
DEFAULT_CONTROLLER = "lag"


@dataclass(frozen=True)
class Scenario:
    """What to run: the step in s, the tolerance in m.

    Attributes
    ----------
    parameters : start values as written, `"2 W/K"` under `motor.joint_conductance`
    mismatches : names of those that change the parameters
    believed : the parameters without them, which is what a law may know; None where there are none
    """

    name: str
    title: str
    about: str
    duty: Duty
    step_size: float = DEFAULT_STEP
    master: str = DEFAULT_MASTER
    controller: str = DEFAULT_CONTROLLER
    tolerance: float = DEFAULT_TOLERANCE
    parameters: dict[str, str | float] = field(default_factory=dict)
    mismatches: tuple[str, ...] = ()
    believed: dict[str, str | float] | None = None

    @property
    def stop_time(self) -> float:
        """Stop time in s, that of the duty cycle."""
        return self.duty.stop_time


_SETTINGS = {
    "title",
    "about",
    "duty",
    "stop_time",
    "step_size",
    "master",
    "controller",
    "tolerance",
    "parameters",
}

_OTHERS = {
    ".ssp": "it is a system: warmlink simulate {}",
    ".fmu": "it is an FMU: warmlink check {}",
    ".ssv": "it is a parameter set: warmlink run --parameters {}",
}
"""What to do with files that are no scenario, by their ending."""


def scenario_names() -> list[str]:
    """Names of the scenarios that warmlink ships, its duty cycles among them."""
    return sorted(_shipped() | set(duty_files.names()))


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
    if name in _shipped():
        return read_scenario(name, read_text(LIBRARY / f"{name}.toml", ""))
    if path.suffix == ".toml":
        return read_scenario(path.stem, read_text(path, "give an existing .toml or .csv"))
    if path.suffix == ".csv" or name in duty_files.names():
        return _of_duty(duty_files.load(name))
    if path.suffix in _OTHERS and is_file(path):
        raise InputError(f"{name}: is no scenario; {_OTHERS[path.suffix].format(name)}")
    raise InputError(
        f"{shortened(name)}: no such scenario; "
        f"{instead(name, scenario_names(), 'or give a TOML or CSV file')}"
    )


def read_scenario(name: str, text: str) -> Scenario:
    """Scenario from the text of its file.

    Raises
    ------
    InputError
        If the text does not hold one.
    """
    return of_tables(name, tables_of(text, name))


def of_tables(name: str, table: Mapping[str, Any]) -> Scenario:
    """Scenario from the tables of its file; raises as `read_scenario`."""
    known_entries(table, _SETTINGS | duty_files.KEYS, name)
    scenario = _of_duty(_duty(name, table))
    return replace(
        scenario,
        name=name,
        title=text_entry(table, "title", scenario.title, name),
        about=text_entry(table, "about", scenario.about, name),
        step_size=positive(table.get("step_size", DEFAULT_STEP), "s", f"{name}: step_size"),
        master=text_entry(table, "master", DEFAULT_MASTER, name),
        controller=text_entry(table, "controller", DEFAULT_CONTROLLER, name),
        tolerance=positive(table.get("tolerance", DEFAULT_TOLERANCE), "m", f"{name}: tolerance"),
        parameters=written_parameters(name, table),
    )


def _of_duty(duty: Duty) -> Scenario:
    return Scenario(duty.name, duty.title, duty.reason, duty)


def _duty(name: str, table: Mapping[str, Any]) -> Duty:
    own = {key: value for key, value in table.items() if key in duty_files.KEYS}
    if "duty" not in table:
        return duty_files.parsed(own, name)
    twice = sorted({"segment", "random", "repeat"} & set(own))
    if twice:
        raise InputError(f"{name}: {twice[0]} beside duty; name a duty cycle or write one, not both")
    duty = duty_files.load(text_entry(table, "duty", "", name))
    if "stop_time" in table:
        duty = replace(duty, stop_time=positive(table["stop_time"], "s", f"{name}: stop_time"))
    return duty


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
