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
from warmlink.orchestration.scenarios import duty_files
from warmlink.orchestration.scenarios.duty import Duty
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.toml_file import is_file, parse_tables, text

LIBRARY = Path(__file__).parent / "library"

DEFAULT_SCENARIO = "windshield_wiper"
DEFAULT_TOLERANCE = 5e-6
DEFAULT_STEP = 1.0
DEFAULT_MASTER = "gauss_seidel"
DEFAULT_CONTROLLER = "lag"

MOST_STEPS = 30 * 24 * 3600
"""Communication steps of a run: every signal is kept at each, and a run has some hundred."""


@dataclass(frozen=True)
class Scenario:
    """What to run: the step in s, the tolerance in m.

    `parameters` holds start values as written, `"2 W/K"` under `motor.joint_conductance`.
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

    def __post_init__(self) -> None:
        """Refuse a run of more steps than memory holds, raising InputError."""
        if self.stop_time > MOST_STEPS * self.step_size:
            raise InputError(
                f"{self.name}: {self.stop_time:g} s in steps of {self.step_size:g} s are more than "
                f"the {MOST_STEPS:,} steps whose signals memory holds, 30 days in steps of a second; stop "
                "earlier, or take a larger step size"
            )

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


def scenario_names() -> list[str]:
    """Names of the scenarios that warmlink ships, its duty cycles among them."""
    return sorted({path.stem for path in LIBRARY.glob("*.toml")} | set(duty_files.names()))


def load_scenario(name: str) -> Scenario:
    """Scenario by the name of a shipped one, or by the path of a TOML or CSV file.

    Raises
    ------
    InputError
        If there is none of that name, or the file does not hold a scenario.
    """
    shipped = LIBRARY / f"{name}.toml"
    if is_file(shipped):
        return read_scenario(name, shipped.read_bytes())
    path = Path(name)
    if path.suffix == ".toml" and is_file(path):
        return read_scenario(path.stem, path.read_bytes())
    if path.suffix in (".toml", ".csv") or name in duty_files.names():
        return _of_duty(duty_files.load(name))
    raise InputError(
        f"{name}: no such scenario; choose {', '.join(scenario_names())}, or give a TOML or CSV file"
    )


def read_scenario(name: str, content: bytes) -> Scenario:
    """Scenario from the content of its file; raises as `load_scenario`."""
    return of_tables(name, parse_tables(content, name))


def of_tables(name: str, table: Mapping[str, Any]) -> Scenario:
    """Scenario from the tables of its file; raises as `load_scenario`."""
    known = _SETTINGS | duty_files.KEYS
    unknown = sorted(set(table) - known)
    if unknown:
        raise InputError(f"{name}: {unknown[0]} is not known; use {', '.join(sorted(known))}")
    duty = _duty(name, table)
    return Scenario(
        name=name,
        title=text(table.get("title", duty.title), f"{name}: title"),
        about=text(table.get("about", duty.reason), f"{name}: about"),
        duty=duty,
        step_size=positive(table.get("step_size", DEFAULT_STEP), "s", f"{name}: step_size"),
        master=text(table.get("master", DEFAULT_MASTER), f"{name}: master"),
        controller=text(table.get("controller", DEFAULT_CONTROLLER), f"{name}: controller"),
        tolerance=positive(table.get("tolerance", DEFAULT_TOLERANCE), "m", f"{name}: tolerance"),
        parameters=_parameters(name, table.get("parameters", {})),
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
    duty = duty_files.load(text(table["duty"], f"{name}: duty"))
    if "stop_time" in table:
        duty = replace(duty, stop_time=positive(table["stop_time"], "s", f"{name}: stop_time"))
    return duty


def _parameters(name: str, table: Any) -> dict[str, str | float]:
    if not isinstance(table, dict):
        raise InputError(f"{name}: parameters is not a table; write [parameters] above them")
    return dict(table)
