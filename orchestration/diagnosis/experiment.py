"""An experiment: several runs on one system, what is known, what is calibrated, how large the noise is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.component import Input, Parameter
from warmlink.orchestration.diagnosis.measured import Column, Run, read_run
from warmlink.orchestration.diagnosis.rigs import Rig, rig
from warmlink.orchestration.diagnosis.values import seconds, to_si
from warmlink.orchestration.text_files import is_file, measured_text, tables_of

HELD_OUT_SHARE = 0.3
"""Share of the time of a bare CSV that is held out, at its end."""

PER_RUN = "run"

_TOP = {
    "title",
    "system",
    "initial",
    "run",
    "channels",
    "covariates",
    "known",
    "calibrate",
    "causes",
    "noise",
}
_RUN = {"data", "labels", "heldout", "adapt", "known"}
_CALIBRATE = {"min", "max", "start", "per"}


@dataclass(frozen=True)
class Calibrated:
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
    initial_measured : whether the states start from the first minute of measurements
    remarks : what the reader should know of how the files were read
    """

    title: str
    rig: Rig
    runs: tuple[Run, ...]
    columns: tuple[Column, ...]
    known: Mapping[str, float] = field(default_factory=dict)
    calibrated: tuple[Calibrated, ...] = ()
    cause_labels: tuple[str, ...] = ()
    noise: Mapping[str, float] = field(default_factory=dict)
    initial_measured: bool = False
    remarks: tuple[str, ...] = ()


def read_experiment(path: Path) -> Experiment:
    """Read an experiment file, or a bare CSV file as a run of the warm-up cell.

    Raises
    ------
    InputError
        What does not fit, with file, row and column or with the table and key.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        return _bare(path)
    if not is_file(path):
        raise InputError(f"{path}: there is no such file; give the path of a .csv or .toml file")
    return _Reader(path, tables_of(measured_text(path), path.name)).experiment()


def _bare(path: Path) -> Experiment:
    system = rig("WarmupCell")
    run, columns = read_run(path, system)
    until = (1 - HELD_OUT_SHARE) * float(run.time[-1])
    return Experiment(path.stem, system, (replace(run, fit_until=until),), columns)


def read_runs(paths: Sequence[Path]) -> Experiment:
    """Read one experiment, or several bare CSV files as runs of one warm-up cell.

    Raises
    ------
    InputError
        What does not fit; an experiment file among several; a run that is given twice.
    """
    for path in paths:
        if len(paths) > 1 and path.suffix.lower() == ".toml":
            raise InputError(
                f"{path}: an experiment file stands alone; give further runs in it, each as a [[run]]"
            )
    experiments = [read_experiment(path) for path in paths]
    for (one, first), (other, second) in combinations(zip(paths, experiments, strict=True), 2):
        if first.runs[0].like(second.runs[0]):
            raise InputError(f"{other}: the same readings as in {one}; give each run once")
    return together(experiments)


def together(experiments: Sequence[Experiment]) -> Experiment:
    """Join experiments on one machine: all their runs, the rest as the first has it."""
    first = experiments[0]
    runs = [run for each in experiments for run in each.runs]
    names = [run.name for run in runs]
    columns: dict[str, Column] = {}
    for column in (c for each in experiments for c in each.columns):
        columns.setdefault(column.variable, column)
    return replace(
        first,
        title=" and ".join(each.title for each in experiments),
        runs=tuple(
            replace(run, name=f"{run.name} ({names[: i + 1].count(run.name)})")
            if names.count(run.name) > 1
            else run
            for i, run in enumerate(runs)
        ),
        columns=tuple(columns.values()),
    )


class _Reader:
    """Takes the tables of one experiment file apart."""

    def __init__(self, path: Path, content: dict[str, Any]) -> None:
        self.name, self.folder, self.content = path.name, path.parent, content
        self._refuse_unknown(content, _TOP, "")
        self.rig = rig(self._text("system"))

    def experiment(self) -> Experiment:
        channels, covariates = self._names("channels"), self._names("covariates")
        given = self.content.get("run")
        if not isinstance(given, list) or not given or not all(isinstance(entry, dict) for entry in given):
            raise InputError(f"{self.name}: there is no [[run]]; give at least one with data = 'FILE.csv'")
        runs: list[Run] = []
        columns: tuple[Column, ...] = ()
        for i, entry in enumerate(given):
            run, columns = self._run(entry, i, channels, covariates)
            runs.append(run)
        if all(run.heldout for run in runs):
            raise InputError(f"{self.name}: every run is held out; leave at least one to fit")
        self._unique([run.name for run in runs])
        title = self.content.get("title", self.name)
        if not isinstance(title, str):
            raise InputError(f'{self.name}: title = {title!r} is not text; write title = "..."')
        initial = self.content.get("initial", "nominal")
        if initial not in ("nominal", "measured"):
            raise InputError(f'{self.name}: initial = {initial!r} is not "nominal" or "measured"')
        causes = self._table("causes")
        self._refuse_unknown(causes, {"per"}, "causes.")
        labels = causes.get("per", [])
        if not isinstance(labels, list):
            raise InputError(f'{self.name}: causes.per = {labels!r} is not a list; write per = ["LABEL"]')
        for label in labels:
            self._check_label(label, runs, "causes.per")
        return Experiment(
            title,
            self.rig,
            tuple(runs),
            columns,
            self._known(self._table("known"), "known"),
            tuple(self._calibrated(v, e, runs) for v, e in self._table("calibrate").items()),
            tuple(labels),
            self._noise(),
            initial == "measured",
        )

    def _run(
        self, entry: dict[str, Any], i: int, channels: dict[str, str], covariates: dict[str, str]
    ) -> tuple[Run, tuple[Column, ...]]:
        where = f"run {i + 1}"
        self._refuse_unknown(entry, _RUN, f"[[{where}]] ")
        if not isinstance(entry.get("data"), str):
            raise InputError(f"{self.name}: {where} has no data; write data = 'FILE.csv'")
        run, columns = read_run(self.folder / entry["data"], self.rig, channels, covariates)
        labels = self._table("labels", entry, f"{where}.")
        for label, value in labels.items():
            if not isinstance(value, str | int | float):
                raise InputError(
                    f"{self.name}: {where}.labels.{label} = {value!r} is not a name; write it as text"
                )
        heldout = entry.get("heldout", False)
        if not isinstance(heldout, bool):
            raise InputError(f"{self.name}: {where}: heldout = {heldout!r} is not true or false")
        return (
            replace(
                run,
                labels={label: str(value) for label, value in labels.items()},
                known=self._known(self._table("known", entry, f"{where}."), f"{where}.known"),
                heldout=heldout,
                adapt=seconds(entry.get("adapt", 0), f"{self.name}: {where}.adapt"),
            ),
            columns,
        )

    def _known(self, table: Mapping[str, object], where: str) -> dict[str, float]:
        known = {}
        for variable, text in table.items():
            place = f"{self.name}: {where}.{variable}"
            scalar = self.rig.scalar(variable, place)
            if not isinstance(scalar.variable, Parameter | Input):
                raise InputError(f"{place}: an output is not given but computed; name a parameter or input")
            known[variable] = to_si(text, scalar, place)
        return known

    def _calibrated(self, variable: str, entry: Any, runs: list[Run]) -> Calibrated:
        place = f"{self.name}: calibrate.{variable}"
        scalar = self.rig.scalar(variable, place)
        if not isinstance(entry, dict):
            raise InputError(f"{place}: give a table {{ min = ..., max = ..., start = ... }}")
        self._refuse_unknown(entry, _CALIBRATE, f"calibrate.{variable} ")
        for key in ("min", "max"):
            if key not in entry:
                raise InputError(f"{place}: {key} is missing; a calibrated variable needs both bounds")
        lower, upper = (to_si(entry[key], scalar, f"{place}.{key}") for key in ("min", "max"))
        if not lower < upper:
            raise InputError(f"{place}: min {lower:g} is not below max {upper:g} {scalar.variable.unit}")
        start = to_si(entry["start"], scalar, f"{place}.start") if "start" in entry else (lower + upper) / 2
        if not lower <= start <= upper:
            raise InputError(f"{place}: start {start:g} lies outside {lower:g} to {upper:g}")
        per = entry.get("per")
        if per is not None and per != PER_RUN:
            self._check_label(per, runs, f"calibrate.{variable}.per")
        return Calibrated(variable, lower, upper, start, per)

    def _noise(self) -> dict[str, float]:
        noise = {}
        for variable, text in self._table("noise").items():
            place = f"{self.name}: noise.{variable}"
            scalar = self.rig.scalar(variable, place)
            noise[variable] = to_si(text, scalar, place, difference=True)
            if not noise[variable] > 0 or not np.isfinite(noise[variable]):
                raise InputError(f"{place}: {text!r} is not a standard deviation above 0")
        return noise

    def _check_label(self, label: object, runs: list[Run], where: str) -> None:
        if not isinstance(label, str):
            raise InputError(
                f'{self.name}: {where}: {label!r} is not the name of a label; write it as "NAME"'
            )
        for run in runs:
            if label not in run.labels:
                raise InputError(
                    f"{self.name}: {where}: run {run.name} has no label {label!r}; add it to its labels"
                )

    def _table(self, key: str, within: dict[str, Any] | None = None, where: str = "") -> dict[str, Any]:
        table = (self.content if within is None else within).get(key, {})
        if not isinstance(table, dict):
            raise InputError(
                f"{self.name}: {where}{key} = {table!r} is not a table; write {key} = {{ NAME = VALUE }}"
            )
        return table

    def _names(self, key: str) -> dict[str, str]:
        """Variable by header."""
        table = self._table(key)
        for header, name in table.items():
            if not isinstance(name, str):
                raise InputError(f'{self.name}: {key}."{header}" = {name!r} is not a name; write it as text')
        return table

    def _text(self, key: str) -> str:
        value = self.content.get(key)
        if not isinstance(value, str):
            missing = "is missing" if value is None else f"= {value!r} is not text"
            raise InputError(f"{self.name}: {key} {missing}; write {key} = '...'")
        return value

    def _unique(self, names: list[str]) -> None:
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"{self.name}: two runs are called {name}; rename one file")

    def _refuse_unknown(self, table: Mapping[str, object], known: set[str], where: str) -> None:
        for key in table:
            if key not in known:
                raise InputError(f"{self.name}: {where}{key} is not known; {instead(key, sorted(known))}")
