"""Python FMUs in hosts, each in a process of its own."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from apart import HOSTS_FOLDER, Outcome, run_apart
from variants import failing_motor, other_motor

from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component, Input
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.packaging.python.fmu import build_python_fmus

HOSTS = ("fmpy", "libcosim", "ecos")
COMPONENTS = {entry.component.name: entry.component for entry in catalogue()}
STEP, STEPS = 0.5, 8


def demands(component: Component, share: float) -> dict[str, float]:
    """Inputs that do something, none of them at its start value."""
    values: dict[str, float] = {}
    for scalar in component.scalars():
        variable = scalar.variable
        if isinstance(variable, Input):
            if variable.type == "Boolean" or variable.type == "Integer":
                values[scalar.name] = 1.0
            else:
                moved = variable.start + share * (5 if variable.unit == "K" else variable.nominal or 1)
                values[scalar.name] = min(moved, math.inf if variable.maximum is None else variable.maximum)
    return values


def job(fmu: Path, component: Component, share: float) -> dict[str, Any]:
    return {
        "fmu": str(fmu),
        "set": demands(component, share),
        "step": STEP,
        "steps": STEPS,
        "watch": component.y.names,
    }


def expected(component: Component, share: float) -> list[list[float]]:
    """The same run without an FMU."""
    instance = Instance(component)
    instance.set(demands(component, share))
    instance.begin()
    instance.initialize()
    rows = []
    for k in range(STEPS):
        instance.step(k * STEP, STEP)
        rows.append([instance.get(name) for name in component.y.names])
    return rows


def require(host: str) -> None:
    module = {"fmpy": "fmpy", "libcosim": "libcosimpy", "ecos": "tbb"}[host]
    if host == "ecos":
        from importlib import metadata

        for name in ("ecospy", "tbb"):
            try:
                metadata.version(name)
            except metadata.PackageNotFoundError:
                pytest.skip(f"{name} is not installed")
    else:
        pytest.importorskip(module, reason=f"{module} is not installed")


@pytest.mark.platform
@pytest.mark.parametrize("host", [host for host in HOSTS if host != "fmpy"])  # in which all run twice below
def test_every_fmu_gives_the_instances_numbers(python_fmus: dict[str, Path], host: str) -> None:
    require(host)
    jobs = [job(python_fmus[name], component, 0.7) for name, component in COMPONENTS.items()]
    outcome = run_apart(f"run_{host}", jobs=jobs)
    for result, (name, component) in zip(outcome.result, COMPONENTS.items(), strict=True):
        # Hosts read Integer and Boolean outputs as such; as numbers they are equal to ours.
        assert [[float(v) for v in row] for row in result["rows"]] == expected(component, 0.7), name


def test_all_fmus_twice_in_one_process_do_not_see_each_other(
    python_fmus: dict[str, Path], tmp_path: Path
) -> None:
    runs = [(python_fmus[name], c, share) for name, c in COMPONENTS.items() for share in (0.2, 0.9)]
    other = other_motor(tmp_path)
    runs.append((build_python_fmus([other], tmp_path)[0], other.component, 0.9))
    outcome = run_apart("run_fmpy", jobs=[job(*run) for run in runs])
    for result, (fmu, component, share) in zip(outcome.result, runs, strict=True):
        assert result["rows"] == expected(component, share), (fmu, share)

    motor = COMPONENTS["MotorHeatSource"].y.names.index("heat_flow")
    own = next(r for r, run in zip(outcome.result, runs, strict=True) if run[0].stem == "MotorHeatSource")
    assert outcome.result[-1]["rows"][-1][motor] != own["rows"][-1][motor]


def test_versions_of_one_component_have_their_own_modules_and_guid(
    python_fmus: dict[str, Path], tmp_path: Path
) -> None:
    from fmpy import read_model_description

    built = build_python_fmus([other_motor(tmp_path / "again")], tmp_path)[0]
    guids = {read_model_description(str(path)).guid for path in (built, python_fmus["MotorHeatSource"])}
    assert len(guids) == 2


@pytest.mark.slow
def test_a_serialised_state_goes_on_bit_for_bit(python_fmus: dict[str, Path]) -> None:
    outcome = run_apart("restore", *map(str, python_fmus.values()))
    moving = {Path(fmu).stem: max(counts) for fmu, counts in outcome.result.items()}
    assert all(moving[name] > 1 for name, component in COMPONENTS.items() if component.states), moving


IDLE_AT_START = ("mean_gate", "camera_authority", "camera_relative_authority")
"""Bounds on averages and pictures that there are none of at the start, though the same functions hold them:
what a model description says of these during initialization is on the safe side."""


PERTURBED = [name for name in COMPONENTS if name not in ("ObserverCompensator", "PoseSequence")]
"""All but two that compute nothing which ObserverDriftCompensator and DutyCycle do not."""


@pytest.fixture(scope="module")
def perturbed(python_fmus: dict[str, Path]) -> dict[str, Any]:
    """What was seen of each FMU, by its path."""
    fmus = (str(python_fmus[name]) for name in PERTURBED)
    found: dict[str, Any] = run_apart("perturb", *fmus, *IDLE_AT_START).result
    return found


@pytest.mark.parametrize("name", PERTURBED)
def test_every_dependency_is_proven_and_every_other_is_absent(
    python_fmus: dict[str, Path], perturbed: dict[str, Any], name: str
) -> None:
    phases = perturbed[str(python_fmus[name])]
    for output, found in phases["outputs"].items():
        assert found["seen"] == found["declared"], output
    for output, found in phases["initial"].items():
        declared, seen = set(found["declared"]), set(found["seen"])
        assert seen <= declared, output
        if found["strict"]:
            assert declared - seen <= set(IDLE_AT_START), output


def test_wrong_use_is_answered_and_survived(python_fmus: dict[str, Path]) -> None:
    assert run_apart("misuse", str(python_fmus["MotorHeatSource"])).result == "survived"


@pytest.mark.slow
@pytest.mark.platform
def test_nothing_of_an_fmu_touches_freed_memory_as_the_process_ends(
    python_fmus: dict[str, Path], tmp_path: Path
) -> None:
    valgrind = shutil.which("valgrind")
    if valgrind is None:
        pytest.skip("valgrind is not installed")
    with ZipFile(python_fmus["Heater"]) as archive:
        archive.extractall(tmp_path)
    command = [
        valgrind,
        "--error-limit=no",
        "--undef-value-errors=no",
        "--keep-stacktraces=none",
        "-q",
        sys.executable,
        str(HOSTS_FOLDER / "end.py"),
    ]
    done = subprocess.run(
        [*command, str(tmp_path), "Heater"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONMALLOC": "malloc"},
        timeout=200,
        check=True,
    )
    faults = re.split(r"\n==\d+== \n", done.stderr)
    assert not [f for f in faults if "finalizePythonInterpreter (in" in f and "Heater.so" in f]
    assert "ended" in done.stdout


@dataclass(frozen=True)
class Misuse:
    """What goes wrong, the word that must be heard of it, and the steps that go well before."""

    values: dict[str, float]
    word: str
    good: int


MISUSES = {
    "parameter": Misuse({"joint_conductance": -1.0}, "joint_conductance: -1 W/K is too low", 0),
    "input": Misuse({"torque": math.nan}, "torque: nan N.m is not a number", 0),
    "exception": Misuse({}, "the magic smoke got out", 5),
}


@pytest.mark.platform
@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("kind", MISUSES)
def test_hosts_survive_what_goes_wrong(tmp_path: Path, host: str, kind: str) -> None:
    require(host)
    misuse = MISUSES[kind]
    entry = failing_motor(tmp_path)
    fmu = build_python_fmus([entry], tmp_path)[0]
    asked = job(fmu, entry.component, 0.7)
    asked["set"] |= misuse.values
    outcome = run_apart(f"run_{host}", jobs=[asked])
    rows = heard(outcome, host, misuse.word)
    if host == "ecos":
        # Ecos neither stops at a discard nor hears the reason; it must not read values that look right.
        assert all(math.isnan(value) for row in rows[misuse.good + 1 :] for value in row)
        assert len(rows) == STEPS
    else:
        assert len(rows) == misuse.good


def heard(outcome: Outcome, host: str, word: str) -> list[list[float]]:
    if host == "fmpy":
        assert any(word in text for text in outcome.result[0]["log"])
    elif host == "libcosim":
        assert word in outcome.output
    return outcome.result[0]["rows"]


def test_an_entry_of_ones_own_needs_no_readme(tmp_path: Path) -> None:
    entry = other_motor(tmp_path / "own")
    assert isinstance(entry, Entry)
    assert not entry.readme.exists()
    assert build_python_fmus([entry], tmp_path)[0].is_file()
