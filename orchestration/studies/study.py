"""Study files: what is varied, over which runs, and what is asked of them.

```toml
title = "Gain and time constant of the lag law"
controller = "lag"                                # or a law of your own, "my_law.py:MyLaw"
duty_cycles = ["windshield_wiper", "stop_and_go"]
mismatches = ["nominal", "thermal_high"]          # default: nominal
seed = 1

[parameters]                                      # instance.variable
"compensator.gain" = { min = "2 um/W", max = "8 um/W" }
"compensator.time_constant" = { min = "10 min", max = "3 h", log = true }

[objective]                                       # smaller is better
metric = "max_abs_um"
over = "cvar"                                     # worst, mean, or cvar: the mean of the worst share
level = 0.25

[[constraint]]
metric = "correction_rate_um_s"
at_most = 0.5

[tune]
trials = 60

[sweep]
kind = "latin_hypercube"                          # or grid
points = 64
```
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.own_law import OwnLaw, is_own_law, load_own_law
from warmlink.orchestration.scenarios.load import load_scenario
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.studies import mismatch as mismatches
from warmlink.orchestration.studies.axis import Axis, read_axis
from warmlink.orchestration.studies.case import Case, case_of
from warmlink.orchestration.studies.mismatch import NOMINAL, Mismatch
from warmlink.orchestration.studies.objective import (
    Constraint,
    Gathered,
    one_of,
    read_constraint,
    read_objective,
)
from warmlink.orchestration.text_files import (
    is_file,
    known_entries,
    read_toml,
    shortened,
    shown,
    text_entry,
    whole_entry,
)

LIBRARY = Path(__file__).parent / "library"

SAMPLERS = ("tpe", "random")
SWEEPS = ("grid", "latin_hypercube")
MOST_POINTS = 100_000
"""Their runs take hours, and a hundred times as many would not fit into memory."""

MOST_SEED = 2**32 - 1
MOST_IN_A_BATCH = 1000
"""More would be chosen knowing nothing of each other, and choosing one more takes longer with each."""

Point = Mapping[str, float]
"""Start values in SI units under `instance.variable`."""

_KEYS = {
    "title",
    "controller",
    "duty_cycles",
    "mismatches",
    "seed",
    "step_size",
    "master",
    "parameters",
    "objective",
    "constraint",
    "tune",
    "sweep",
}


@dataclass(frozen=True)
class TuneSettings:
    """How to tune: `batch` trials are chosen at a time, whatever the number of workers."""

    trials: int = 60
    batch: int = 8
    sampler: str = "tpe"
    storage: str | None = None


@dataclass(frozen=True)
class SweepSettings:
    """What to sweep: so many values an axis for a grid, so many points in all for a hypercube."""

    kind: str = "grid"
    points: int = 5


@dataclass(frozen=True)
class Study:
    """A study file, checked."""

    name: str
    title: str
    controller: str
    law: Component
    own: OwnLaw | None
    scenarios: tuple[Scenario, ...]
    mismatches: tuple[Mismatch, ...]
    seed: int
    axes: tuple[Axis, ...]
    objective: Gathered
    constraints: tuple[Constraint, ...]
    tune: TuneSettings
    sweep: SweepSettings

    def cases(self, point: Point, label: str) -> list[Case]:
        """The runs of one point: each duty cycle with each mismatch.

        Raises
        ------
        InputError
            If a component refuses the point.
        """
        return [
            case_of(
                mismatch.applied(replace(duty, parameters={**duty.parameters, **point}), self.law),
                self.law,
                (label, duty.name, mismatch.name),
            )
            for duty in self.scenarios
            for mismatch in self.mismatches
        ]

    @property
    def kinds(self) -> set[str]:
        """Components of ours that the runs need."""
        return {kind for scenario in self.scenarios for kind in scenario.setup.kinds([self.law])}

    @property
    def foreign(self) -> dict[str, Path]:
        """FMUs of others that they need, by the component's name."""
        return {name: path for scenario in self.scenarios for name, path in scenario.setup.foreign.items()}

    @property
    def runs(self) -> list[tuple[str, str]]:
        """Duty cycle and mismatch of each run of a point."""
        return [(duty.name, mismatch.name) for duty in self.scenarios for mismatch in self.mismatches]

    @property
    def shipped(self) -> Point | None:
        """The point where nothing is changed; None where the bounds leave it out."""
        if all(axis.holds_shipped for axis in self.axes):
            return {axis.name: axis.shipped for axis in self.axes}
        return None

    def digest(self, fmus: str) -> str:
        """Digest of what the trials depend on, their number left out, with that of the FMUs."""
        facts: dict[str, Any] = {
            "cases": [case.digest for case in self.cases({}, "")],
            "axes": [asdict(axis) for axis in self.axes],
            "objective": asdict(self.objective),
            "constraints": [asdict(constraint) for constraint in self.constraints],
            "seed": self.seed,
            "batch": self.tune.batch,
            "sampler": self.tune.sampler,
            "fmus": fmus,
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:12]


def names() -> list[str]:
    """Names of the example studies that warmlink ships."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def load_study(name: str) -> Study:
    """Study from a TOML file, or a shipped one by its name.

    Raises
    ------
    InputError
        If there is none, or it asks for what does not exist or cannot be.
    """
    path = LIBRARY / f"{name}.toml" if name in names() else Path(name)
    if not is_file(path):
        raise InputError(f"{shortened(name)}: no such study; {instead(name, names(), 'or give a TOML file')}")
    return read_study(path.stem, read_toml(path), path.parent)


def read_study(name: str, given: Mapping[str, Any], folder: Path) -> Study:
    """Study from the tables of its file; files that it names are looked for in `folder` too."""
    known_entries(given, _KEYS, name)
    law, own, controller = _law(given.get("controller"), folder, name)
    duties, wrong = _named(given, "duty_cycles", name), _named(given, "mismatches", name, (NOMINAL,))
    scenarios = tuple(_scenario(each, given, folder, name, controller) for each in duties)
    declared = scenarios[0].setup.declared(law)
    parameters = given.get("parameters")
    if not isinstance(parameters, dict) or not parameters:
        raise InputError(
            f'{name}: varies nothing; write [parameters] and "compensator.gain" = {{ min = ..., max = ... }}'
        )
    constraints = given.get("constraint", [])
    if not isinstance(constraints, list):
        raise InputError(f"{name}: constraint is not a list of tables; write [[constraint]]")
    study = Study(
        name=name,
        title=text_entry(given, "title", name, name),
        controller=controller,
        law=law,
        own=own,
        scenarios=scenarios,
        mismatches=tuple(mismatches.load(_beside(each, folder)) for each in wrong),
        seed=whole_entry(given.get("seed", 1), 0, MOST_SEED, f"{name}: seed"),
        axes=tuple(read_axis(key, table, declared, name) for key, table in parameters.items()),
        objective=read_objective(given.get("objective", {}), f"{name}: objective"),
        constraints=tuple(
            read_constraint(table, f"{name}: constraint {i}") for i, table in enumerate(constraints, 1)
        ),
        tune=_tune(given.get("tune", {}), f"{name}: tune"),
        sweep=_sweep(given.get("sweep", {}), f"{name}: sweep"),
    )
    study.cases({}, name)
    return study


def _law(given: Any, folder: Path, name: str) -> tuple[Component, OwnLaw | None, str]:
    if not isinstance(given, str):
        raise InputError(f'{name}: names no controller; write controller = "lag"')
    if is_own_law(given):
        own = load_own_law(_beside(given, folder))
        return own.component, own, own.name
    return catalogue.controller(given), None, given


def _scenario(duty: str, given: Mapping[str, Any], folder: Path, name: str, controller: str) -> Scenario:
    scenario = replace(load_scenario(_beside(duty, folder)), controller=controller)
    if "step_size" in given:
        scenario = replace(scenario, step_size=positive(given["step_size"], "s", f"{name}: step_size"))
    if "master" in given:
        master = text_entry(given, "master", "", name)
        algorithm(master)
        scenario = replace(scenario, master=master)
    return scenario


def _beside(place: str, folder: Path) -> str:
    """A file beside the study file, where there is one of that name."""
    near = folder / place.partition(":")[0]
    return str(folder / place) if near.suffix and is_file(near) else place


def _named(given: Mapping[str, Any], key: str, name: str, default: Sequence[str] = ()) -> list[str]:
    listed = given.get(key, list(default))
    if not isinstance(listed, list) or not listed or not all(isinstance(each, str) for each in listed):
        raise InputError(f'{name}: {key} is no list of names; write {key} = ["windshield_wiper"], say')
    if len(set(listed)) < len(listed):
        raise InputError(f"{name}: {key} names one twice; keep one")
    return listed


def _tune(table: Any, where: str) -> TuneSettings:
    known_entries(table, {"trials", "batch", "sampler", "storage"}, where)
    default = TuneSettings()
    storage = table.get("storage")
    if storage is not None and not (isinstance(storage, str) and "://" in storage):
        raise InputError(f"{where}.storage: {shown(storage)} is no URL; write sqlite:///study.db, say")
    trials = whole_entry(table.get("trials", default.trials), 1, MOST_POINTS, f"{where}.trials")
    batch = whole_entry(table.get("batch", default.batch), 1, MOST_IN_A_BATCH, f"{where}.batch")
    sampler = one_of(SAMPLERS, table.get("sampler", default.sampler), f"{where}.sampler")
    return TuneSettings(trials, batch, sampler, storage)


def _sweep(table: Any, where: str) -> SweepSettings:
    known_entries(table, {"kind", "points"}, where)
    kind = one_of(SWEEPS, table.get("kind", "grid"), f"{where}.kind")
    return SweepSettings(kind, whole_entry(table.get("points", 5), 1, MOST_POINTS, f"{where}.points"))
