"""The candidates for what is wrong in an experiment, as numbers that fits may free; nothing is simulated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.causes.catalogue import Cause
from warmlink.orchestration.diagnosis.data.experiment import Calibration, Experiment
from warmlink.orchestration.diagnosis.data.experiment_file import PER_RUN
from warmlink.orchestration.diagnosis.data.measured import Run, names_of
from warmlink.orchestration.diagnosis.data.thinning import Thinned, thinned
from warmlink.orchestration.diagnosis.fit.offers import freed_by
from warmlink.orchestration.diagnosis.model.instruments import channel_of, neutral
from warmlink.orchestration.diagnosis.model.simulation import (
    initial_values,
    input_table,
    start_values,
    unread_starts,
)
from warmlink.orchestration.machine.rig import OFFSET

_INNER = ("plant", "input", "place")
"""Kinds of causes that change the simulation itself, not only what is read from it."""

_START, _PER_KELVIN = 10.0, 1e-5
"""K by which a measured start may be off, and m of the camera that count as much as 1 K of a sensor."""

_UNREAD = 100.0
"""K by which a start that no reading tells may be off: a winding that is heated as its run begins."""

_DENIED, _DENIED_LEAST = 10.0, 0.5
"""Scatter of the readings, and K at least, by which the first ones deny a start that was given."""


@dataclass(frozen=True)
class FreeNumber:
    """One number to be fitted.

    Attributes
    ----------
    variable : the FMU variable, or the first of several that share the value
    slots : indices of the variables that take the value
    runs : indices of the runs in which it acts
    lower, upper, start : bounds and starting value in SI; for a cause the start is the neutral value, where
        runs have several known ones that of the first
    group : value of the label that it belongs to, "" for all
    calibrated : whether every model fits it, the uncorrected one included
    added : whether it is added to each variable's own value
    """

    variable: str
    slots: tuple[int, ...]
    runs: tuple[int, ...]
    lower: float
    upper: float
    start: float
    group: str = ""
    calibrated: bool = False
    added: bool = False

    @property
    def key(self) -> tuple[str, str, bool]:
        """Identifies the number in problems with other runs."""
        return self.variable, self.group, self.calibrated

    @property
    def span(self) -> float:
        """Size of an ordinary change, by which steps are scaled."""
        return self.upper - self.lower

    def on_bound(self, value: float) -> bool:
        """Whether a value lies on a bound that is not the starting value."""
        near = 1e-6 * self.span
        return min(value - self.lower, self.upper - value) <= near < abs(value - self.start)


@dataclass(frozen=True)
class Item:
    """A candidate: a cause, on one channel if it belongs to an instrument, and perhaps split by a label."""

    name: str
    cause: Cause
    freed: tuple[FreeNumber, ...]
    label: str = ""

    @property
    def title(self) -> str:
        """Name with the label that splits it."""
        return f"{self.name} per {self.label}" if self.label else self.name

    def covers(self, other: Item) -> bool:
        """Whether this candidate has the effect of another, of the same part, among others."""
        same_part = self.name.partition(":")[2] == other.name.partition(":")[2]
        return other.cause.name in self.cause.covers and same_part


class Candidates:
    """Numbers that fits may free, and the slots that take their values.

    Attributes
    ----------
    variables : outputs that were measured, in order
    names : column name by variable
    data : thinned readings by run
    inner, outer, slots : variables that may be freed, of the simulation, of the instruments, and both
    calibrated : numbers that every model fits
    items : candidates
    """

    def __init__(self, experiment: Experiment) -> None:
        self.experiment, self.names = experiment, names_of(experiment.columns)
        self.variables = tuple(self.names)
        self.data: tuple[Thinned, ...] = tuple(thinned(run, self.variables) for run in experiment.runs)
        offers = ((cause, freed_by(cause, experiment, self.names)) for cause in experiment.catalogue)
        self._offered = [(cause, *named) for cause, each in offers for named in each]
        self.inner, self.outer = self._slots()
        self.slots = (*self.inner, *self.outer)

    @cached_property
    def neutral(self) -> tuple[Array, ...]:
        """Slots of each run where nothing is fitted."""
        rig, outer = self.experiment.rig, [neutral(name) for name in self.outer]
        every = ((run, self.known(run)) for run in self.experiment.runs)
        inner = (start_values(rig, self.inner, known, input_table(rig, run, known)) for run, known in every)
        return tuple(np.append(each, outer) for each in inner)

    def known(self, run: Run) -> Mapping[str, float]:
        """Known values of any run on the system and its initial states, in SI."""
        known = {**self.experiment.known, **run.known}
        if self.experiment.initial_measured:
            known = {**initial_values(self.experiment.rig, run, known), **known}
        return known

    @cached_property
    def fitted_runs(self) -> tuple[int, ...]:
        """Indices of the runs with rows to fit."""
        return tuple(i for i, d in enumerate(self.data) if d.fitted.any())

    @property
    def numbers(self) -> list[FreeNumber]:
        """Every number that some model fits."""
        return [*self.calibrated, *(freed for item in self.items for freed in item.freed)]

    def values(self, run: int, freed: Iterable[FreeNumber], theta: Iterable[float]) -> Array:
        """Slots of a run for fitted values: some are added, and of others in one slot the later counts."""
        z = self.neutral[run].copy()
        for parameter, value in zip(freed, theta, strict=True):
            if run in parameter.runs:
                slots = list(parameter.slots)
                z[slots] = z[slots] + value if parameter.added else value
        return z

    def values_by_run(self, freed: Sequence[FreeNumber], theta: Sequence[float] | Array) -> list[Array]:
        """Slots of every run for fitted values."""
        return [self.values(run, freed, theta) for run in range(len(self.data))]

    @cached_property
    def calibrated(self) -> tuple[FreeNumber, ...]:
        """Numbers that every model fits."""
        stated = (
            FreeNumber(each.variable, slot, runs, each.lower, each.upper, each.start, group, calibrated=True)
            for each in self.experiment.calibrated
            for slot in [(self.slots.index(each.variable),)]
            for group, runs in self._groups(each.per)
        )
        return (*stated, *self._starts)

    @cached_property
    def _starts(self) -> tuple[FreeNumber, ...]:
        """What a measured start leaves open: temperatures at the start of each run, and the camera's zero.

        So does a start that is given and that the first readings deny, where no cause is there to say so.
        """
        return tuple(
            FreeNumber(name, (self.slots.index(name),), (i,), -span, span, 0.0, run.name, True, added=True)
            for i, run in enumerate(self.experiment.runs)
            for name, span in self._open_at_start(i, run).items()
        )

    def _open_at_start(self, i: int, run: Run) -> dict[str, float]:
        """What a run's start leaves open, and by how much in the variable's unit."""
        if not (self.experiment.initial_measured or self.experiment.calibrated):
            return {}
        stated = {each.variable for each in self.experiment.calibrated}
        free = [name for name in self.slots if name not in stated]
        read = initial_values(self.experiment.rig, run, self.known(run))
        if self.experiment.initial_measured:
            spans = {
                **dict.fromkeys(read, _START),
                **dict.fromkeys(unread_starts(self.experiment.rig, run), _UNREAD),
                **dict.fromkeys(self._camera_offsets, _START * _PER_KELVIN),
            }
            return {name: span for name, span in spans.items() if name in free}
        least = max(_DENIED * float(max(self.data[i].scatter, default=0.0)), _DENIED_LEAST)
        given = {name: float(self.neutral[i][self.slots.index(name)]) for name in read if name in free}
        off = [read[name] - start for name, start in given.items()]
        # A cause may shift all starts alike, but not one against the other.
        apart = max(off, default=0.0) - min(off, default=0.0)
        denied = max(map(abs, off), default=0.0) if self.experiment.only_calibrated else apart
        if denied <= least:
            return {}
        return {name: _START + abs(each) for name, each in zip(given, off, strict=True)}

    @cached_property
    def items(self) -> tuple[Item, ...]:
        """Candidates that this experiment's data and system allow.

        Where there is no motor, warmer air at the link is warmer air everywhere: such twins are offered once.
        """
        if self.experiment.only_calibrated:
            return ()
        unlike: dict[tuple[object, ...], Item] = {}
        starts = {slot for freed in self._starts for slot in freed.slots}
        for item in (item for offer in self._offered for item in self._items_of(*offer)):
            if starts.issuperset(item.freed[0].slots):
                continue
            frees = tuple((f.slots, f.runs, f.lower, f.upper, f.start) for f in item.freed)
            unlike.setdefault((frees, item.label), item)
        return tuple(unlike.values())

    def _items_of(self, cause: Cause, name: str, variables: tuple[str, ...]) -> Iterable[Item]:
        slots = tuple(self.slots.index(v) for v in variables)
        also = next((c for c in self.experiment.calibrated if c.variable == variables[0]), None)
        # An instrument stays the same from run to run; what surrounds and covers the machine may not.
        varies = cause.kind == "plant" and not (cause.material or cause.each_run)
        for label in ("", *(self.experiment.cause_labels if varies else ())):
            own = cause.each_run and len(self.experiment.runs) > 1
            every = self._groups(PER_RUN if own else label or None)
            # The calibrated value serves the first group.
            groups = every if also is None else every[1:]
            if groups and not (label and len(every) < 2):
                freed = tuple(
                    FreeNumber(variables[0], slots, runs, *bounds, group, added=cause.added)
                    for group, runs in groups
                    for bounds in [self._bounds_of(cause, variables[0], slots[0], runs[0], also)]
                )
                # A share of a known 0 is 0: such a cause has nothing to change.
                if all(each.span > 0 for each in freed):
                    yield Item(name, cause, freed, label)

    def _bounds_of(
        self, cause: Cause, variable: str, slot: int, run: int, also: Calibration | None
    ) -> tuple[float, float, float]:
        """Lower and upper bound of a cause's number, and its start; `also` where it is calibrated as well.

        A known value beyond the usual bounds is within them.
        """
        nominal = float(self.neutral[run][slot])
        camera = variable in self._camera_offsets and not cause.declared
        size = (nominal if cause.relative else 1.0) * (_PER_KELVIN if camera else 1.0)
        lower, upper = cause.lower * size, cause.upper * size
        if also is not None:
            lower, upper, nominal = also.lower, also.upper, also.start
        start = nominal if cause.neutral is None else cause.neutral
        return min(lower, upper, start), max(lower, upper, start), start

    @cached_property
    def _camera_offsets(self) -> set[str]:
        channels = [channel_of(self.experiment.rig, variable) for variable in self.variables]
        return {channel.variable("offset") for channel in channels if channel.is_camera}

    def _slots(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What candidates may free: in the simulation, and of the instruments."""
        inner = [c.variable for c in self.experiment.calibrated]
        outer: list[str] = []
        for cause, _, variables in self._offered:
            (inner if cause.kind in _INNER else outer).extend(variables)
        inner += (slot for slots in self.experiment.rig.wandering.values() for slot in slots)
        inner += (f"{OFFSET}:{name}" for run in self.experiment.runs for name in run.scatter)
        return tuple(dict.fromkeys(inner)), tuple(dict.fromkeys(outer))

    def _groups(self, label: str | None) -> list[tuple[str, tuple[int, ...]]]:
        """Runs by the value of a label; every run if there is none."""
        runs = self.experiment.runs
        of = ["" if label is None else {**run.labels, PER_RUN: run.name}[label] for run in runs]
        values = dict.fromkeys(of[i] for i in (*self.fitted_runs, *range(len(runs))))
        return [(v, tuple(i for i, each in enumerate(of) if each == v)) for v in values]
