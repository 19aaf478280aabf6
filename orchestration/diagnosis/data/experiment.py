"""An experiment: several runs on one system, what is known, what is calibrated, how large the noise is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Input, Parameter
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.causes.catalogue import Cause, catalogue
from warmlink.orchestration.diagnosis.causes.declared import CausesFile, causes_of, read_causes
from warmlink.orchestration.diagnosis.data.experiment_file import (
    MEASURED,
    PER_RUN,
    CalibrateTable,
    ExperimentFile,
)
from warmlink.orchestration.diagnosis.data.measured import Column, Run, names_of, read_run
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.machine.added_heat import Paths
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.machine.sums import with_sums
from warmlink.orchestration.machine.terms import PlacedTerm, placed_term
from warmlink.orchestration.scenarios.overrides import si_in_range, to_si
from warmlink.orchestration.text_files import demand_file, measured_text, tables_of
from warmlink.orchestration.written.tables import read_table

if TYPE_CHECKING:
    import pandas as pd

HELD_OUT_SHARE = 0.3
"""Share of the time of a bare CSV that is held out, at its end."""


@dataclass(frozen=True)
class Calibration:
    """A variable that every model may fit: bounds and start in SI; `per` a label, "run" or None."""

    variable: str
    lower: float
    upper: float
    start: float
    per: str | None = None


@dataclass(frozen=True)
class Experiment:
    """What a diagnosis works on, all in SI.

    Attributes
    ----------
    columns : measured columns, by which results are named
    known : value by variable, for all runs
    cause_labels : labels by which a cause's parameters may differ from run to run
    noise : 1 sigma by output, where it is given
    accuracy : error by output below which a model is good enough, where it is given
    initial_measured : whether the states start from the first minute of measurements
    remarks : what the reader should know of how the files were read
    declared, with_shipped : causes of this system, and whether the shipped ones are thought of as well
    only_calibrated : whether no cause is looked for, though what causes may do is no noise all the same
    time_limit : longest time in s that a calibration may take
    """

    title: str
    rig: Rig
    runs: tuple[Run, ...]
    columns: tuple[Column, ...]
    known: Mapping[str, float] = field(default_factory=dict)
    calibrated: tuple[Calibration, ...] = ()
    cause_labels: tuple[str, ...] = ()
    noise: Mapping[str, float] = field(default_factory=dict)
    initial_measured: bool = False
    remarks: tuple[str, ...] = ()
    declared: tuple[Cause, ...] = ()
    with_shipped: bool = True
    only_calibrated: bool = False
    accuracy: Mapping[str, float] = field(default_factory=dict)
    time_limit: float = math.inf

    @property
    def catalogue(self) -> tuple[Cause, ...]:
        """Causes to think of: the shipped and the declared ones, which replace shipped ones of their name."""
        shipped = catalogue() if self.with_shipped else ()
        return tuple({each.name: each for each in (*shipped, *self.declared)}.values())

    def understood(self) -> dict[str, Any]:
        """What the files were understood to be, what is assumed and passed over, as JSON."""
        runs, remarks = [run.understood() for run in self.runs], list(self.remarks)
        return {"system": self.rig.name, "runs": runs, "known": dict(self.known), "remarks": remarks}


def calibrating(experiment: Experiment, time_limit: float = math.inf) -> Experiment:
    """The same, to look for no cause within a time limit in s; InputError where nothing is calibrated."""
    if not experiment.calibrated:
        raise InputError(
            f"{argument('only_calibrated')}: {experiment.title} calibrates nothing; name under [calibrate] "
            'in an experiment file what is to be fitted, as "link.convection_still" = { min = 2, max = 12 }'
        )
    return replace(experiment, only_calibrated=True, time_limit=time_limit)


def read_experiment(source: Path | pd.DataFrame, options: ReadOptions = DEFAULT_OPTIONS) -> Experiment:
    """Read an experiment (TOML), or bare measurements, also as a DataFrame, as a run of one machine.

    The user gives `options`: the machine, and units and names of columns. InputError is raised for what
    does not fit, with file, row and column or with the table and key.
    """
    if isinstance(source, Path) and source.suffix.lower() == ".toml":
        demand_file(source, "give the path of a .csv or .toml file")
        return _Reader(source, options).experiment()
    cell = rig_of(options.machine, replaced=options.replaced)
    run = read_run(source, cell, options=options)
    until = (1 - HELD_OUT_SHARE) * float(run.time[-1])
    return Experiment(run.name, cell, (replace(run, fit_until=until),), run.measured)


def read_runs(sources: Sequence[Path | pd.DataFrame], options: ReadOptions = DEFAULT_OPTIONS) -> Experiment:
    """Read one experiment, or several bare files of measurements as runs of one warm-up cell.

    InputError is raised as by `read_experiment`, for a run given twice or an experiment among several, and
    for a named column that no file has.
    """
    for path in sources if len(sources) > 1 else ():
        if isinstance(path, Path) and path.suffix.lower() == ".toml":
            raise InputError(
                f"{path}: an experiment file cannot be combined with other files; "
                "give further runs in it, each as a [[run]]"
            )
    experiments = [read_experiment(source, options) for source in sources]
    names = [source if isinstance(source, Path) else "a DataFrame" for source in sources]
    for (one, first), (other, second) in combinations(zip(names, experiments, strict=True), 2):
        if first.runs[0].like(second.runs[0]):
            raise InputError(f"{other}: the same readings as in {one}; give each run once")
    whole = together(experiments)
    for header, sentence in whole.runs[0].absent.items():
        if all(header in run.absent for run in whole.runs):
            raise InputError(sentence)
    return whole


def together(experiments: Sequence[Experiment]) -> Experiment:
    """Join experiments on one machine: all their runs, the rest as the first has it."""
    first = experiments[0]
    runs = [run for each in experiments for run in each.runs]
    names = [run.name for run in runs]
    for i, run in enumerate(runs):
        if names.count(run.name) > 1:
            runs[i] = replace(run, name=f"{run.name} ({names[: i + 1].count(run.name)})")
    columns: dict[str, Column] = {}
    for column in (c for each in experiments for c in each.columns):
        columns.setdefault(column.variable, column)
    title = " and ".join(each.title for each in experiments)
    return replace(first, title=title, runs=tuple(runs), columns=tuple(columns.values()))


def noise_of(
    rig: Rig, variable: str, text: str | float, where: str, what: str = "a standard deviation"
) -> float:
    """Size in SI of an output's noise, or of `what` else, as written; InputError if it has none."""
    size = to_si(text, rig.scalar(variable, where), where, difference=True)
    if not size > 0:
        raise InputError(f"{where}: {text!r} is not {what} above 0")
    return size


class _Reader:
    """Reads what an experiment file says of the variables of its system."""

    def __init__(self, path: Path, options: ReadOptions) -> None:
        self.name, self.folder, self.options = path.name, path.parent, options
        self.file = read_table(ExperimentFile, tables_of(measured_text(path), path.name), path.name)
        causes = self.file.causes.file
        self.declared = CausesFile(()) if causes is None else read_causes(self.folder / causes)
        rig = rig_of(self.file.system, self.folder, self.declared.paths, self.file.in_loop, options.replaced)
        if self.file.term:
            paths: Paths = {**self.declared.paths, **self._terms(rig)}
            rig = rig_of(self.file.system, self.folder, paths, self.file.in_loop, options.replaced)
        # Where a heat path was put before an input, its own input is meant.
        self.moved = rig.moved
        self.channels = {header: self.moved.get(name, name) for header, name in self.file.channels.items()}
        self.rig = with_sums(
            rig.measured_at(self.channels.values()), self.channels.values(), f"{self.name}: channels"
        )
        self.runs: list[Run] = []

    def _terms(self, rig: Rig) -> dict[str, PlacedTerm]:
        """Terms of the file by name, at their places in the system."""
        return {
            name: placed_term(
                rig, name, each.heat, each.into, each.parameters, f"{self.name}: term.{name}", each.inputs
            )
            for name, each in self.file.term.items()
        }

    def experiment(self) -> Experiment:
        file, rig = self.file, self.rig
        for i, table in enumerate(file.run, 1):
            run = read_run(self.folder / table.data, rig, self.channels, file.covariates, self.options)
            known = self._known(table.known, f"run {i}.known")
            if run.name in [each.name for each in self.runs]:
                raise InputError(f"{self.name}: two runs are called {run.name}; rename one file")
            run = replace(run, labels=table.labels, heldout=table.heldout, adapt=table.adapt)
            self.runs.append(replace(run, known=known))
        if all(run.heldout for run in self.runs):
            raise InputError(f"{self.name}: every run is held out; leave at least one to fit")
        for label in file.causes.per:
            self._check_label(label, "causes.per")
        known, columns = self._known(file.known, "known"), self.runs[-1].measured
        idle = (run for run in self.runs if run.adapt and not run.heldout)
        told = "changes nothing, as the whole run is fitted; hold it out (heldout = true), or leave adapt out"
        where = f"{self.name}: {file.causes.file}"
        declared = causes_of(self.declared, rig.scalar, known, names_of(columns), where)
        return Experiment(
            self.name if file.title is None else file.title,
            rig,
            tuple(self.runs),
            columns,
            known,
            tuple(self._calibrated(name, table) for name, table in file.calibrate.items()),
            file.causes.per,
            self._sizes(file.noise, "noise", "a standard deviation"),
            file.initial == MEASURED,
            tuple(f"{run.name}: adapt = {run.adapt:g} s {told}" for run in idle),
            declared=tuple(declared),
            with_shipped=file.causes.shipped,
            accuracy=self._sizes(file.accuracy, "accuracy", "an error"),
        )

    def _sizes(self, table: Mapping[str, str | float], key: str, what: str) -> dict[str, float]:
        """Sizes of differences in SI by output, which the file names as such or by its column."""
        named = {n: self.file.channels.get(n, n) for n in table}
        return {
            named[n]: noise_of(self.rig, named[n], text, f"{self.name}: {key}.{n}", what)
            for n, text in table.items()
        }

    def _known(self, table: Mapping[str, str | float], where: str) -> dict[str, float]:
        known = {}
        for name, text in table.items():
            variable, place = self.moved.get(name, name), f"{self.name}: {where}.{name}"
            scalar = self.rig.scalar(variable, place)
            if not isinstance(scalar.variable, Parameter | Input):
                raise InputError(f"{place}: an output is not given but computed; name a parameter or input")
            known[variable] = si_in_range(text, scalar, place)
        return known

    def _calibrated(self, name: str, table: CalibrateTable) -> Calibration:
        variable = self.moved.get(name, name)
        place = f"{self.name}: calibrate.{variable}"
        scalar = self.rig.scalar(variable, place)
        lower, upper = to_si(table.min, scalar, f"{place}.min"), to_si(table.max, scalar, f"{place}.max")
        if not lower < upper:
            raise InputError(
                f"{place}: min {table.min} is not below max {table.max}; exchange or correct them"
            )
        start = (lower + upper) / 2 if table.start is None else to_si(table.start, scalar, f"{place}.start")
        if not lower <= start <= upper:
            given = f"start {table.start} lies outside {table.min} to {table.max}"
            raise InputError(f"{place}: {given}; choose one between them")
        if table.per is not None:
            self._check_label(table.per, f"calibrate.{variable}.per")
        return Calibration(variable, lower, upper, start, table.per)

    def _check_label(self, label: str, where: str) -> None:
        for run in self.runs if label != PER_RUN else ():
            if label not in run.labels:
                raise InputError(
                    f"{self.name}: {where}: run {run.name} has no label {label!r}; add it to its labels"
                )
