"""What the page needs to read a measured run, and to write its scenario."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warmlink.fmus.pose_sequence.equations import AXES, POSES
from warmlink.orchestration.arm.blueprint import POSES as POSE_SEQUENCE
from warmlink.orchestration.scenarios.duties.duty_csv import DEMANDS, MEASURED
from warmlink.orchestration.scenarios.quantity import converter
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.text_files import read_toml

UNITS = {
    "s": ("s", "min", "h", "ms"),
    "K": ("K", "degC", "°C", "degF"),
    "m": ("m", "mm", "um", "µm", "nm"),
    "rad/s": ("rad/s", "deg/s", "rpm"),
    "N.m": ("N.m", "N*m"),
    "W": ("W", "kW"),
}
"""Spellings of units that the page knows, by SI unit; the command knows more."""


def columns(plots: Mapping[tuple[str, str], Mapping[str, str]]) -> dict[str, dict[str, Any]]:
    """Columns of a measured run by name: units with factor and offset into SI, and what they measure."""
    lines: dict[str, tuple[str, str]] = {}
    for (_, unit), of in plots.items():
        lines |= {name.removeprefix("link, "): (unit, variable) for name, variable in of.items()}
    known: dict[str, dict[str, Any]] = {name: {"units": _units(unit)} for name, unit in DEMANDS.items()}
    for name in MEASURED:
        unit, variable = lines.get(name.removesuffix("_temperature"), ("", ""))
        if variable:
            known[name] = {"units": _units(unit), "variable": variable}
    return known


def _units(unit: str) -> dict[str, tuple[float, float]]:
    found = {spelled: converter(spelled, unit) for spelled in UNITS[unit]}
    return {spelled: (each.factor, each.offset) for spelled, each in found.items()}


def file_content(scenario: Scenario) -> dict[str, Any]:
    """What a scenario's file says besides its duty cycle, with which the page writes one."""
    tables: dict[str, Any] = {}
    top: dict[str, Any] = {
        "title": scenario.title,
        "step_size": f"{scenario.step_size!r} s",
        "master": scenario.master,
        "tolerance": f"{scenario.tolerance!r} m",
    }
    written = {} if scenario.file is None else read_toml(scenario.file)
    if "roles" in written:
        top["system"], tables["roles"] = written["system"], written["roles"]
    poses = scenario.values().get(POSE_SEQUENCE, {})
    if poses:
        top["system"] = scenario.setup.name
    sensors = {"noise": scenario.sensors.noise, "used": scenario.sensors.used}
    tables["sensors"] = {name: value for name, value in sensors.items() if value is not None}
    return {
        "top": top,
        "tables": tables,
        "parameters": scenario.parameters,
        "poses": [
            {
                "hold": poses[f"duration[{i}]"],
                "joints": [poses[f"joint_{joint}[{i}]"] for joint in range(1, AXES + 1)],
            }
            for i in range(1, POSES + 1)
            if poses.get(f"duration[{i}]")
        ],
    }
