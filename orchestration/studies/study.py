"""Study files: what is varied, over which runs, and what is asked of them; see `warmlink init study`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.arguments import count_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.catalogue import Controller, controller_named
from warmlink.orchestration.closed_loop.load import driven, load_scenario
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.scenarios import mismatch as mismatches
from warmlink.orchestration.scenarios.mismatch import NOMINAL, Mismatch
from warmlink.orchestration.scenarios.scenario import Scenario, believing
from warmlink.orchestration.studies.axis import Axis, AxisTable, read_axis
from warmlink.orchestration.studies.case import Case, Constraint, Gathered, case_of
from warmlink.orchestration.text_files import absent, is_file, read_toml, shown
from warmlink.orchestration.written.entries import Names, OneOf, Quantity, Text, Whole
from warmlink.orchestration.written.tables import Table, read_table

LIBRARY = Path(__file__).parent / "library"

SAMPLERS, SWEEPS = ("tpe", "random"), ("grid", "latin_hypercube")
MOST_SEED, MOST_POINTS = 2**32 - 1, 100_000
"""The runs of that many points take hours, and a hundred times as many would not fit into memory."""

MOST_IN_A_BATCH = 1000
"""More would be chosen knowing nothing of each other, and choosing one more takes longer with each."""

Point = Mapping[str, float]
"""Start values in SI units under `instance.variable`."""


@dataclass(frozen=True)
class TuneSettings(Table):
    """How to tune: `batch` trials are chosen at a time, whatever the number of workers."""

    trials: Annotated[int, Whole(1, MOST_POINTS)] = 60
    batch: Annotated[int, Whole(1, MOST_IN_A_BATCH)] = 8
    sampler: Annotated[str, OneOf(SAMPLERS)] = "tpe"
    storage: Annotated[str | None, Text("sqlite:///study.db")] = None

    def __post_init__(self) -> None:
        if self.storage is not None and "://" not in self.storage:
            raise InputError(f"storage: {shown(self.storage)} is no URL; write sqlite:///study.db, say")


@dataclass(frozen=True)
class SweepSettings(Table):
    """What to sweep: so many values for each axis of a grid, so many points in all of a hypercube."""

    kind: Annotated[str, OneOf(SWEEPS)] = "grid"
    points: Annotated[int, Whole(1, MOST_POINTS)] = 5


@dataclass(frozen=True)
class StudyFile(Table):
    """A study: what is varied, over which runs, and what is asked of them."""

    controller: Annotated[str, Text("lag")]
    parameters: Mapping[str, AxisTable]
    duty_cycles: Annotated[tuple[str, ...] | None, Names("windshield_wiper")] = None
    title: Annotated[str | None, Text()] = None
    scenario: Annotated[str | None, Text("my_cell.toml")] = None
    mismatches: Annotated[tuple[str, ...], Names(NOMINAL)] = (NOMINAL,)
    seed: Annotated[int, Whole(0, MOST_SEED)] = 1
    step_size: Annotated[float | None, Quantity("s", positive=True)] = None
    master: Annotated[str | None, Text("gauss_seidel")] = None
    objective: Gathered = field(default_factory=Gathered)
    second_objective: Gathered | None = None
    constraint: tuple[Constraint, ...] = ()
    tune: TuneSettings = TuneSettings()
    sweep: SweepSettings = SweepSettings()

    def __post_init__(self) -> None:
        if self.duty_cycles is None and self.scenario is None:
            raise InputError('duty_cycles is missing; write duty_cycles = ["windshield_wiper"]')
        if not self.parameters:
            raise InputError(
                'varies nothing; write [parameters] and "compensator.gain" = { min = ..., max = ... }'
            )


@dataclass(frozen=True)
class Study:
    """A study file, checked."""

    name: str
    title: str
    controller: Controller
    scenarios: tuple[Scenario, ...]
    mismatches: tuple[Mismatch, ...]
    seed: int
    axes: tuple[Axis, ...]
    objectives: tuple[Gathered, ...]
    constraints: tuple[Constraint, ...]
    tune: TuneSettings
    sweep: SweepSettings

    def cases(self, point: Point, label: str) -> list[Case]:
        """The runs of one point, each duty cycle with each mismatch; InputError if a component refuses it."""
        return [
            case_of(believing(each, point), (label, *names))
            for names, each in zip(self.run_names, self.runs, strict=True)
        ]

    @cached_property
    def runs(self) -> tuple[Scenario, ...]:
        """The runs of a point where nothing is varied: each duty cycle with each mismatch."""
        return tuple(duty.mismatched(each) for duty in self.scenarios for each in self.mismatches)

    @property
    def run_names(self) -> list[tuple[str, str]]:
        """Duty cycle and mismatch of each run."""
        return [(duty.name, each.name) for duty in self.scenarios for each in self.mismatches]

    @property
    def objective(self) -> Gathered:
        """The first one."""
        return self.objectives[0]

    @property
    def shipped(self) -> Point | None:
        """The point where nothing is changed; None where none of the points that can be chosen is that."""
        found = {axis.name: value for axis in self.axes if (value := axis.as_shipped) is not None}
        return found if len(found) == len(self.axes) else None

    def lasting(self, trials: int | None) -> Study:
        """The same with another number of trials; raises InputError if that is not a count."""
        if trials is None:
            return self
        count = count_given("trials", trials, 1, MOST_POINTS, "trials")
        return replace(self, tune=replace(self.tune, trials=count))

    def lines(self, point: Point) -> list[str]:
        """A point in lines for the terminal."""
        return [f"  {axis.name:<36}{axis.shown(point[axis.name]):>20}" for axis in self.axes]

    def digest(self, fmus: str) -> str:
        """Digest of what the trials depend on, their number left out, with that of the FMUs."""
        facts = {
            "cases": [case.digest for case in self.cases({}, "")],
            "axes": [asdict(axis) for axis in self.axes],
            "constraints": [asdict(constraint) for constraint in self.constraints],
            "seed": self.seed,
            "batch": self.tune.batch,
            "sampler": self.tune.sampler,
            "fmus": fmus,
            **{k: asdict(v) for k, v in zip(("objective", "second"), self.objectives, strict=False)},
        }
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:12]


def names() -> list[str]:
    """Names of the example studies that warmlink ships."""
    return sorted(path.stem for path in LIBRARY.glob("*.toml"))


def load_study(name: str) -> Study:
    """Study from a TOML file, or a shipped one by its name.

    InputError if there is none, or it asks for what does not exist or cannot be.
    """
    path = LIBRARY / f"{name}.toml" if name in names() else Path(name)
    if is_file(path):
        return read_study(path.stem, read_toml(path), path.parent)
    raise absent(path, instead(name, names(), "or give a TOML file"), "study")


def read_study(name: str, given: Mapping[str, Any], folder: Path) -> Study:
    """Study from the tables of its file; files that it names are looked for in `folder` too."""
    file = read_table(StudyFile, given, name)
    controller = controller_named(_beside(file.controller, folder))
    cell = None if file.scenario is None else load_scenario(_beside(file.scenario, folder))
    duties = file.duty_cycles or (file.scenario or "",)
    scenarios = tuple(_scenario(_beside(each, folder), file, controller, cell) for each in duties)
    known = [(each, each.as_believed.values()) for each in scenarios]
    study = Study(
        name=name,
        title=name if file.title is None else file.title,
        controller=controller,
        scenarios=scenarios,
        mismatches=tuple(mismatches.load(_beside(each, folder)) for each in file.mismatches),
        seed=file.seed,
        axes=tuple(read_axis(key, each, known, name) for key, each in file.parameters.items()),
        objectives=tuple(each for each in (file.objective, file.second_objective) if each is not None),
        constraints=file.constraint,
        tune=file.tune,
        sweep=file.sweep,
    )
    study.cases({}, name)  # which checks all start values
    return study


def _scenario(duty: str, file: StudyFile, controller: Controller, cell: Scenario | None) -> Scenario:
    scenario = load_scenario(duty) if cell is None else driven(cell, load_scenario(duty))
    if file.master is not None:
        algorithm(file.master)
        scenario = replace(scenario, master=file.master)
    return replace(scenario, controller=controller, step_size=file.step_size or scenario.step_size)


def _beside(place: str, folder: Path) -> str:
    """A file beside the study file, where there is one of that name."""
    near = folder / place.partition(":")[0]
    return str(folder / place) if near.suffix and is_file(near) else place
