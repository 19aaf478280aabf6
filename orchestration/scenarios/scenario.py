"""Scenario files: a duty cycle, the cell it runs in, and how it is run."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.scenarios.duty import DutyCycle, read_duty
from warmlink.orchestration.scenarios.quantity import positive

DEFAULT_SCENARIO = "windshield_wiper"
DEFAULT_TOLERANCE = 5e-6
DEFAULT_STEP = 1.0


@dataclass(frozen=True)
class Scenario:
    """What to run: times in s, the tolerance in m.

    `parameters` holds start values as written, `"2 W/K"` under `motor.joint_conductance`.
    """

    name: str
    title: str
    duty: DutyCycle
    stop_time: float
    about: str = ""
    step_size: float = DEFAULT_STEP
    master: str = "gauss_seidel"
    controller: str = "lag"
    tolerance: float = DEFAULT_TOLERANCE
    parameters: dict[str, str | float] = field(default_factory=dict)


_KEYS = {
    "title",
    "about",
    "stop_time",
    "step_size",
    "master",
    "controller",
    "tolerance",
    "repeat",
    "segment",
    "parameters",
}


def scenario_names() -> list[str]:
    """Names of the scenarios that warmlink ships."""
    return sorted(Path(entry.name).stem for entry in _library().iterdir() if entry.name.endswith(".toml"))


def load_scenario(name: str) -> Scenario:
    """Scenario by the name of a shipped one or the path of a TOML file.

    Raises
    ------
    InputError
        If there is none of that name, or the file does not hold a scenario.
    """
    if name in scenario_names():
        return read_scenario(name, (_library() / f"{name}.toml").read_bytes())
    path = Path(name)
    if path.suffix == ".toml":
        if not path.is_file():
            raise InputError(
                f"{path}: no such file; give a scenario's TOML file or a name from `warmlink list`"
            )
        return read_scenario(path.stem, path.read_bytes())
    raise InputError(
        f"{name}: no such scenario; choose {', '.join(scenario_names())}, or give a TOML file of your own"
    )


def read_scenario(name: str, content: bytes) -> Scenario:
    """Scenario from the content of its file."""
    table = _toml(name, content)
    unknown = sorted(set(table) - _KEYS)
    if unknown:
        raise InputError(f"{name}: {unknown[0]} is not known; use {', '.join(sorted(_KEYS))}")
    duty = read_duty(_tables(table, "segment", name), bool(table.get("repeat", False)), name)
    total = sum(segment.duration for segment in duty.segments)
    return Scenario(
        name=name,
        title=str(table.get("title", name)),
        about=str(table.get("about", "")),
        duty=duty,
        stop_time=positive(table.get("stop_time", total), "s", f"{name}: stop_time"),
        step_size=positive(table.get("step_size", DEFAULT_STEP), "s", f"{name}: step_size"),
        master=str(table.get("master", "gauss_seidel")),
        controller=str(table.get("controller", "lag")),
        tolerance=positive(table.get("tolerance", DEFAULT_TOLERANCE), "m", f"{name}: tolerance"),
        parameters=dict(table.get("parameters", {})),
    )


def _toml(name: str, content: bytes) -> dict[str, Any]:
    try:
        return tomllib.loads(content.decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as fault:
        raise InputError(f"{name}: not a TOML file ({fault}); mend that place") from None


def _tables(table: dict[str, Any], key: str, name: str) -> list[dict[str, Any]]:
    entries = table.get(key, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{name}: {key} is not a list of tables; write [[{key}]] above each")
    return entries


def _library() -> Any:
    return resources.files("warmlink.orchestration.scenarios") / "library"
