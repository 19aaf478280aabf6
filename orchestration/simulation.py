"""Run a system of FMUs from any tool."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import several
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.master.algorithms import DEFAULT_MASTER
from warmlink.orchestration.master.algorithms.algorithm import Algorithm
from warmlink.orchestration.master.algorithms.named import algorithm
from warmlink.orchestration.master.error_budget import Once
from warmlink.orchestration.master.guard import Remark, guarded
from warmlink.orchestration.master.recording.recorder import is_recorded
from warmlink.orchestration.master.recording.result import Result
from warmlink.orchestration.master.run import simulate as simulate_system
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.plausible import declared_in, within_bands
from warmlink.orchestration.scenarios.system_values import Written, full_name, with_parameters
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.described import described
from warmlink.orchestration.system.description import FmuVariable, read_description
from warmlink.orchestration.system.model import System
from warmlink.orchestration.written.quantities import positive

DEFAULT_STEPS = 500
_ROUNDING = 1e-6
"""Of a step."""

Simulated = Callable[..., Result]
"""A run of some steps, by an `algorithm`; `line` as for `master.run.simulate`."""


def simulate(
    system: str | Path | System,
    stop: str | float | None = None,
    step: str | float | None = None,
    *,
    variant: str | None = None,
    parameters: Mapping[str, Written] | str | Path = MappingProxyType({}),
    master: str = DEFAULT_MASTER,
    record: Sequence[str] | None = None,
    fmu_tolerance: float | None = None,
) -> Result:
    """Run a system of FMUs, or a single FMU.

    Parameters
    ----------
    system : an SSP or an FMU from any tool, or a system that was read or made
    parameters : start values by full name, as `link.length`, in the variable's own unit or as `"400 mm"`; or
        the path of a parameter set (SSV)
    stop, step : stop time and communication step size, `"1 h"` or in s; what the system proposes by default
    variant : which system, of several in one SSP, by default `SystemStructure`
    master : name of the algorithm
    record : variables to keep, as `link.elongation`; every output by default
    fmu_tolerance : relative tolerance of the solvers inside the FMUs; what each FMU proposes by default

    Raises
    ------
    InputError
        If the file or something in it cannot be used, or a name is not known.
    SlaveError
        If the run failed before its first communication point.

    Examples
    --------
    >>> result = wl.simulate("dist/WarmupCell.ssp", "1 h", parameters={"link.length": "400 mm"})
    >>> result["link.elongation"].max()
    """
    chosen = algorithm(master)
    with temporary_folder() as work:
        if isinstance(system, System) and variant is not None:
            raise InputError(f"{argument('variant', variant)}: the system has been read; leave it out")
        read = (
            system if isinstance(system, System) else read_system(path_given("system", system), work, variant)
        )
        read = with_parameters(read, parameters)
        for told in read.remarks:
            remark(told)
        times = experiment_of(read, stop, step)
        for told in remarks_on_steps(read, *times, stop):
            remark(told)
        names = None if record is None else [full_name(read, name) for name in several(record)]
        how: dict[str, Any] = {"start_time": read.default_experiment.start_time, "record": names}
        how["fmu_tolerance"] = relative_tolerance(fmu_tolerance)
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

    Without a step, FMUs that take steps of one size alone are stepped so, up to the last such point.
    InputError if there is no stop time, or what is given is not a time.
    """
    proposed = system.default_experiment
    stop_time = proposed.stop_time if stop is None else positive(stop, "s", argument("stop"))
    if stop_time is None:
        raise InputError(
            f'{system.name}: the system proposes no stop time; give one, as {argument("stop")} "1 h"'
        )
    if stop_time <= proposed.start_time:
        raise InputError(
            f"{argument('stop', stop or stop_time)}: the run begins at {proposed.start_time:g} s, as the "
            "system proposes; give a later stop time"
        )
    step_size = proposed.step_size if step is None else positive(step, "s", argument("step"))
    duration, own = stop_time - proposed.start_time, own_steps(system)
    if step_size is None and own:
        step_size = _common(own.values())
        count = math.floor(duration / step_size + _ROUNDING)
        stop_time = stop_time if count == 0 else proposed.start_time + count * step_size
    return stop_time, step_size or _usual_step(system, duration)


def _usual_step(system: System, duration: float) -> float:
    """Give one of `DEFAULT_STEPS` in s, or a multiple of what FMUs step inside that divides the run."""
    usual = duration / DEFAULT_STEPS
    infos = (described(held) for held in system.components.values())
    inside = [info.capabilities.internal_step for info in infos if info.capabilities.internal_step]
    if inside and _divides(part := _common(inside), duration):
        least, count = max(1, math.ceil(usual / part - _ROUNDING)), round(duration / part)
        return part * next((m for m in range(least, 10 * least) if count % m == 0), 1)
    return usual


def own_steps(system: System) -> dict[str, float]:
    """Step in s of each component whose FMU proposes one and does not want it to be changed."""
    infos = {name: described(held) for name, held in system.components.items()}
    return {name: info.own_step for name, info in infos.items() if info.own_step}


def _common(steps: Iterable[float]) -> float:
    """Smallest step in s that is a whole multiple of all."""
    parts = [Fraction(repr(step)) for step in steps]
    bottom = math.lcm(*(part.denominator for part in parts))
    return math.lcm(*(int(part * bottom) for part in parts)) / bottom


def remarks_on_steps(
    system: System, stop_time: float, step_size: float, stop: str | float | None = None
) -> list[str]:
    """Say where steps do not fit an FMU, and where a run ends before the `stop` that was asked for."""
    found, duration = [], stop_time - system.default_experiment.start_time
    for name, held in system.components.items():
        info = described(held)
        own, inside = info.own_step, info.capabilities.internal_step
        if own and not _divides(own, step_size):
            count = max(1, math.floor(duration / own + _ROUNDING))
            there = stop_time - duration + count * own
            remedy = "" if _divides(own, duration) else f' {argument("stop")} "{there:.10g} s"'
            told = f"proposes steps of {own:g} s and declares that it takes no others"
            found.append(f'{name}: {told}; give {argument("step")} "{own:.10g} s"{remedy}')
        elif inside and not _divides(inside, step_size):
            told = f"goes on by {inside:g} s inside, which does not divide the run's steps of {step_size:g} s"
            found.append(f'{name}: {told}; give a multiple, as {argument("step")} "{10 * inside:g} s"')
    asked = system.default_experiment.stop_time if stop is None else positive(stop, "s", argument("stop"))
    if asked is not None and stop_time < asked - _ROUNDING * step_size:
        found.append(
            f"the run ends at {stop_time:.10g} s: no step of {step_size:g} s ends at {asked:.10g} s, and "
            f"{', '.join(own_steps(system))} declares that it takes no others"
        )
    return found


def halvable(system: System, step_size: float) -> bool:
    """Whether every FMU can go on by half a step: one with an internal step can do so by multiples of it."""
    inside = (described(held).capabilities.internal_step for held in system.components.values())
    return all(_divides(each, step_size / 2) for each in inside if each)


def _divides(part: float, whole: float) -> bool:
    return abs(whole / part - round(whole / part)) <= _ROUNDING and round(whole / part) > 0


def relative_tolerance(value: str | float | None) -> float | None:
    """Give a relative tolerance for FMUs; InputError if it is not above 0."""
    return None if value is None else positive(value, "1", argument("fmu_tolerance"))


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
            found[name] = positive(tolerance, known[name].unit or "1", f"{argument('tolerance')} of {name}")
    if not found and not watched:
        raise InputError(
            f"{argument('tolerance', tolerance)}: fits no output; give a value above 0 in the unit of one"
        )
    return found


def variables(system: System) -> dict[str, FmuVariable]:
    """Every variable of a system's FMUs, as `link.elongation`."""
    return {
        f"{name}.{variable.name}": variable
        for name, held in system.components.items()
        for variable in read_description(held.fmu).variables.values()
    }
