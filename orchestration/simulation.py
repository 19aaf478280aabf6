"""Run a system of FMUs from any tool."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import progress_bar, remark
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.table import algorithm
from warmlink.orchestration.master.error_budget import Once
from warmlink.orchestration.master.guard import Remark, guarded
from warmlink.orchestration.master.recording.recorder import is_recorded
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate as simulate_system
from warmlink.orchestration.plausible import declared_in, within_bands
from warmlink.orchestration.scenarios.entries import positive
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import Variable, read_description
from warmlink.orchestration.system.model import System

DEFAULT_STEPS = 500

Simulated = Callable[..., Result]
"""A run of some steps, by an `algorithm`; `line` as for `master.run.simulate`."""


def simulate(
    system: str | Path | System,
    stop: str | float | None = None,
    step: str | float | None = None,
    *,
    master: str = "jacobi",
    record: Sequence[str] | None = None,
) -> Result:
    """Run a system of FMUs.

    Parameters
    ----------
    system : an SSP file from any tool, or a system that was read or made
    stop, step : stop time and communication step size, `"1 h"` or in s; what the system proposes by default
    master : name of the algorithm
    record : variables to keep, as `link.elongation`; every output by default

    Raises
    ------
    InputError
        If the file or something in it cannot be used, or a name is not known.
    SlaveError
        If the run failed before its first communication point.
    """
    chosen = algorithm(master)
    with temporary_folder() as work:
        read = system if isinstance(system, System) else read_system(Path(system), work)
        for told in read.remarks:
            remark(told)
        times = experiment_of(read, stop, step)
        how: dict[str, Any] = {"start_time": read.default_experiment.start_time, "record": record}
        with progress_bar(read.name) as progress:
            found = guarded(
                lambda line: simulate_system(read, *times, chosen, unpacked=work, line=line, **how),
                lambda done, count: progress(done / count),
                remark,
            )
        return within_bands(found, declared_in(read))


def in_turns(
    whole: Simulated, half: Simulated, progress: Callable[[float], None], remark: Remark | None = None
) -> Once:
    """Runs, each in a process of its own: one with the whole step, and one with half of it.

    The second one takes twice as long. Progress is the share of both that is done.
    """

    def once(by: Algorithm, halved: bool) -> Result:
        run, before, share = (half, 1 / 3, 2 / 3) if halved else (whole, 0.0, 1 / 3)
        return guarded(
            lambda line: run(algorithm=by, line=line),
            lambda done, count: progress(before + share * done / count),
            remark,
        )

    return once


def experiment_of(system: System, stop: str | float | None, step: str | float | None) -> tuple[float, float]:
    """Stop time and communication step size in s: what is given, or what the system proposes.

    InputError if there is no stop time, or a time is none.
    """
    proposed = system.default_experiment
    stop_time = proposed.stop_time if stop is None else positive(stop, "s", "--stop")
    if stop_time is None:
        raise InputError(f'{system.name}: the system proposes no stop time; give one, as --stop "1 h"')
    step_size = proposed.step_size if step is None else positive(step, "s", "--step")
    return stop_time, step_size or (stop_time - proposed.start_time) / DEFAULT_STEPS


def largest_step(system: System, stop_time: float, longest: float | None) -> float:
    """Largest communication step in s that divides a run and exceeds neither `longest` nor a sample time."""
    duration = stop_time - system.default_experiment.start_time
    found = [duration / DEFAULT_STEPS if longest is None else longest]
    for held in system.components.values():
        variable = read_description(held.fmu).variables.get("sample_time")
        value = held.values.get("sample_time", variable.start) if variable else None
        if isinstance(value, float) and value > 0:
            found.append(value)
    return duration / max(1, math.ceil(duration / min(found) - 1e-9))


def tolerances_of(system: System, tolerance: str, watched: Sequence[str] | None) -> dict[str, float]:
    """Largest coupling error by variable, in its unit: of those watched, or of all Real outputs that it fits.

    InputError if the tolerance is not above 0, or does not fit.
    """
    known = variables(system)
    found = {}
    outputs = (name for name, each in known.items() if is_recorded(each) and each.kind == "Real")
    for name in watched or outputs:
        with suppress(KeyError if watched else InputError):
            found[name] = positive(tolerance, known[name].unit or "1", f"--tolerance of {name}")
    if not found and not watched:
        raise InputError(f"--tolerance {tolerance}: fits no output; give a value above 0 in the unit of one")
    return found


def variables(system: System) -> dict[str, Variable]:
    """Every variable of a system's FMUs, as `link.elongation`."""
    return {
        f"{name}.{variable.name}": variable
        for name, held in system.components.items()
        for variable in read_description(held.fmu).variables.values()
    }
