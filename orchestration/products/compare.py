"""Controllers compared: in simulated runs, or on measured logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.replay.compare import TOLERANCE, Replayed, logged_on, replayed
from warmlink.orchestration.replay.logs import sources_in
from warmlink.orchestration.scenarios.overrides import StartValueSet, given_values
from warmlink.orchestration.studies.compare import Comparison, compared, plan_on
from warmlink.orchestration.studies.session import USUAL, RunOptions

if TYPE_CHECKING:
    from warmlink.orchestration.replay.logs import Logs


def compare(
    controllers: Sequence[str] | str | None = None,
    duty_cycles: Sequence[str | Path] | str | Path | None = None,
    mismatches: Sequence[str | Path] | str | Path | None = None,
    *,
    system: str = DEFAULT,
    scenario: str | Path | None = None,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    options: RunOptions = USUAL,
    out: str | Path | None = None,
    data: Logs | None = None,
    learn: Logs = (),
    tolerance: str | float | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
    names: Mapping[str, str] = MappingProxyType({}),
    decimal: str = "",
) -> Comparison | Replayed:
    """Compare controllers with each other and with no compensation, in simulated runs or on measured logs.

    Parameters
    ----------
    controllers : names, or laws of one's own as `my_law.py:MyLaw`; all that are designed for the system
    duty_cycles, mismatches : names or files; all that are usual for the system
    system : WarmupCell or SixAxisArm
    scenario : file (TOML) of a cell of one's own, whose parameters and sensors hold in every duty cycle; its
        own is the usual one; of measured logs, of any machine: its roles say which variables the columns
        are, and its tolerance holds
    parameters : start values, or the path of a parameter set (SSV), for the controllers that have them
    options : kind of FMU and number of processes
    out : folder in which finished runs are kept, so that the same call goes on where it was interrupted
    data : measured logs (files or DataFrames) to judge on instead, without any plant: a controller sees what
        was logged, and its error is the measured growth minus its correction
    learn : logs from which the controllers that can learn do so first; give others than in `data`
    tolerance : error that production allows, of measured logs, as `"5 um"`, which it is by default, or in m
    units, names, decimal : of the logs' columns, as `diagnose` takes them

    Raises
    ------
    InputError
        If there is none of a name, a value is refused, or a log does not fit.

    Examples
    --------
    >>> print(wl.compare(["lag", "observer"], ["stop_and_go"], ["thermal_high"]))
    """
    values = given_values(parameters)
    sets = [StartValueSet("parameters", values)] if values else []
    if data is None:
        logged = {"learn": bool(sources_in(learn)), "tolerance": tolerance is not None}
        logged |= {"units": bool(units), "names": bool(names), "decimal": bool(decimal)}
        for name in (name for name, is_given in logged.items() if is_given):
            raise InputError(f"{argument(name)}: is for measured logs; give them as {argument('data')}")
        plan = plan_on(system, controllers, duty_cycles, mismatches, sets, scenario)
        with compared(plan, options, out) as comparison:
            return comparison
    given = {"duty_cycles": duty_cycles is not None, "mismatches": mismatches is not None}
    given |= {"system": system != DEFAULT, "options": options != USUAL, "out": out is not None}
    for name in (name for name, is_given in given.items() if is_given):
        raise InputError(f"{argument(name)}: measured logs are compared as they are; leave it out")
    reading = ReadOptions(units, names=names, decimal=decimal)
    if scenario is not None:
        reading, tolerance = logged_on(str(scenario), reading, tolerance)
    with spinner("Replaying"):
        return replayed(
            *(data, controllers, sets),
            learn=learn,
            tolerance=TOLERANCE if tolerance is None else tolerance,
            options=reading,
        )
