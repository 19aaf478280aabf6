"""Laws judged on measured logs, without any plant: each sees what was logged, row by row.

A law's error is the growth that was measured, or that the log holds as the truth, minus the law's correction.
A law that uses a camera sees the growth whenever it was measured, minus the correction that it had made by
then: its loop is closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from statistics import fmean, median
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.replay import ReplayedOutputs, period, replay
from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import several
from warmlink.fmus.safe_text import write_frame
from warmlink.orchestration import catalogue
from warmlink.orchestration.catalogue import controller_named, refuse_one_name
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.metrics import conduct, error_metrics
from warmlink.orchestration.console import Answer
from warmlink.orchestration.diagnosis.data.inputs import of_scenario
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.replay.learn import LEARNS, learnt_law
from warmlink.orchestration.replay.logs import MeasuredLog, read_logs, sources_in
from warmlink.orchestration.scenarios.overrides import StartValueSet, assigned, start_values
from warmlink.orchestration.written.quantities import positive

if TYPE_CHECKING:
    import pandas

    from warmlink.orchestration.replay.logs import Logs

SETTLING = 120.0
"""s after a start for which a law may be off: its correction moves from 0, no faster than its limit."""

TOLERANCE = "5 um"
"""Error that production allows, if nobody says otherwise."""

_PLACES = {"rms_um": 2, "outside_percent": 2, "ready_wrong_percent": 2, "travel_um_h": 0}
"""Decimal places that are shown, where they are not one."""

FIGURES: Mapping[str, Callable[[Sequence[float]], float]] = {
    "removed_percent": median,
    "rms_um": median,
    "worst_um": max,
    "outside_percent": fmean,
    "ready_percent": fmean,
    "ready_wrong_percent": fmean,
    "fine_not_ready_percent": fmean,
    "travel_um_h": fmean,
}
"""How each figure of a law is combined over several logs; `leap_um` is told of each log alone."""


@dataclass(frozen=True)
class ReplayFigures:
    """What a law did in one log.

    Errors, `ready` and the growth that they are compared with leave out the first `SETTLING` seconds; travel
    and leaps are those of the whole log.

    Attributes
    ----------
    removed_percent : 100 (1 - largest error / largest growth); None if there was no growth
    rms_um, worst_um : error
    outside_percent : of the time beyond the tolerance
    ready_percent, ready_wrong_percent, fine_not_ready_percent, travel_um_h, leap_um : as in the table of
        `warmlink compare`
    """

    removed_percent: float | None
    rms_um: float
    worst_um: float
    outside_percent: float
    ready_percent: float
    ready_wrong_percent: float
    fine_not_ready_percent: float
    travel_um_h: float
    leap_um: float


COLUMNS = ("controller", "log", *(each.name for each in fields(ReplayFigures)))
"""Columns of `logs.csv`."""


def replay_figures(law: Component, log: MeasuredLog, tolerance: float) -> ReplayFigures:
    """Run a law over a log; raises InputError where the law refuses a parameter.

    A law samples no faster than the log has rows: a reading that repeats itself is none to it.

    Parameters
    ----------
    law : with the start values of its parameters
    log : measured
    tolerance : in m
    """
    _, outputs, acting = run_over(law, log)
    growth = log.reference_growth
    known = np.flatnonzero(np.isfinite(growth) & (log.time - log.time[0] > SETTLING))
    if known.size < 2:
        raise InputError(
            f"{log.name}: the growth was measured {known.size} times after the first 2 min; give a longer log"
        )
    time, at = log.time[known], acting[known]
    error = growth[known] - outputs.correction[at]
    figures = error_metrics(time, error, tolerance)
    said = conduct(time, error, [outputs.ready[at]], [], tolerance)
    moved = conduct(log.time, np.zeros(log.time.size), [], [outputs.correction[acting]], tolerance)
    most = 1e6 * float(np.max(np.abs(growth[known])))
    spans = np.diff(time, append=time[-1])
    return ReplayFigures(
        removed_percent=100 * (1 - figures.max_abs_um / most) if most > 0 else None,
        rms_um=figures.rms_um,
        worst_um=figures.max_abs_um,
        outside_percent=100 * float(spans @ (np.abs(error) > tolerance) / spans.sum()),
        ready_percent=said.ready_percent,
        ready_wrong_percent=said.ready_wrong_percent,
        fine_not_ready_percent=said.fine_not_ready_percent,
        travel_um_h=moved.travel_um_h,
        leap_um=moved.leap_um,
    )


@dataclass(frozen=True, repr=False)
class Replayed(Answer):
    """Laws judged on logs: figures by controller and log, in the order asked for."""

    controllers: tuple[str, ...]
    logs: tuple[str, ...]
    rows: Mapping[tuple[str, str], ReplayFigures]
    tolerance_um: float

    def over_all(self, controller: str) -> dict[str, float]:
        """Figures of a law over all logs, as `FIGURES` says."""
        rows = [self.rows[controller, log] for log in self.logs]
        found = {}
        for name, of in FIGURES.items():
            values = [value for row in rows if (value := getattr(row, name)) is not None]
            found[name] = of(values) if values else math.nan
        return found

    def table(self) -> list[tuple[str, ...]]:
        """A line for each law with its figures over all logs, as text."""
        return [
            (name, *(f"{value:.{_PLACES.get(of, 1)}f}" for of, value in self.over_all(name).items()))
            for name in self.controllers
        ]

    def records(self) -> list[dict[str, Any]]:
        """Every law in every log with its figures by name, as JSON has them."""
        return [{"controller": a, "log": b, **asdict(row)} for (a, b), row in self.rows.items()]

    def to_frame(self) -> pandas.DataFrame:
        """A row for each law and log with its figures."""
        import pandas

        return pandas.DataFrame(self.records(), columns=list(COLUMNS))

    def summary(self) -> str:
        """A line for each law."""
        import pandas

        frame = pandas.DataFrame([self.over_all(name) for name in self.controllers], index=self.controllers)
        return f"{len(self.logs)} logs, ±{self.tolerance_um:g} µm\n{frame.round(2).to_string()}"

    def write_csv(self, path: Path) -> None:
        """Write one row for each law and log."""
        write_frame(self.to_frame().round(6), path)


def run_over(
    law: Component, log: MeasuredLog
) -> tuple[NDArray[np.float64], ReplayedOutputs, NDArray[np.intp]]:
    """What a law saw and said at its samples over a log, and which sample acts at each row of the log.

    It samples no faster than the log has rows. What it saw is in the order of its inputs, shape (m, u.size).
    """
    step = max(period(law), log.spacing)
    if step > period(law) and "sample_time" in law.p.index:
        law = replace(law, parameters=with_scalars(law.parameters, {"sample_time": step}))
    inputs, measured, acting = log.inputs_of(law, step)
    return inputs, replay(law, inputs, measured), acting


def replayed(
    data: Logs,
    controllers: Sequence[str] | str | None = None,
    sets: Sequence[StartValueSet] = (),
    *,
    learn: Logs = (),
    tolerance: str | float = TOLERANCE,
    options: ReadOptions = DEFAULT_OPTIONS,
    progress: Callable[[float], None] = lambda done: None,
) -> Replayed:
    """Judge laws on measured logs.

    Parameters
    ----------
    data : files or DataFrames of logs to be judged on, columns as `diagnose` reads them
    controllers : names, or laws of one's own; all that ship by default
    sets : start values, later ones outdo earlier ones; a law takes those of its own parameters
    learn : logs from which the laws that can learn do so; give others than in `data`
    tolerance : error that production allows, as `"5 um"`, or in m
    options : units and names of columns
    progress : called with the share that is done

    Raises
    ------
    InputError
        A file does not fit, a law or parameter does not exist, two laws have one name, or a log holds too
        little.
    """
    allowed = positive(tolerance, "m", argument("tolerance"))
    names = list(catalogue.controllers()) if controllers is None else several(controllers)
    found = [controller_named(name) for name in dict.fromkeys(names)]
    refuse_one_name("controllers", (law.name for law in found))
    laws = {law.name: law.component for law in found}
    data, learn = sources_in(data), sources_in(learn)
    if learn:
        taught = learnt_law(learn, options=options)
        for name in (each for each in LEARNS if each in laws):
            given = replace(taught, law=name).parameters
            laws[name] = _with(laws[name], {k.removeprefix(f"{COMPENSATOR}."): v for k, v in given.items()})
    for name, values in assigned(sets, laws).items():
        own = start_values(values, {COMPENSATOR: laws[name]}, name).get(COMPENSATOR, {})
        laws[name] = _with(laws[name], {"tolerance": allowed, **{k: float(v) for k, v in own.items()}})
    logs = read_logs(data, options)
    rows: dict[tuple[str, str], ReplayFigures] = {}
    for name, law in laws.items():
        for log in logs:
            rows[name, log.name] = replay_figures(law, log, allowed)
            progress(len(rows) / (len(laws) * len(logs)))
    return Replayed(tuple(laws), tuple(log.name for log in logs), rows, 1e6 * allowed)


def logged_on(
    scenario: str, options: ReadOptions, tolerance: str | float | None
) -> tuple[ReadOptions, str | float]:
    """How the logs of a scenario's machine are read, and its tolerance in m if no other is given.

    InputError if there is no such scenario, or it is driven by programs of its own.
    """
    machine, _ = of_scenario(scenario)
    allowed = load_scenario(scenario).tolerance if tolerance is None else tolerance
    return replace(options, machine=machine), allowed


def _with(law: Component, values: Mapping[str, float]) -> Component:
    known = {name: value for name, value in values.items() if name in law.p.index}
    return replace(law, parameters=with_scalars(law.parameters, known))
