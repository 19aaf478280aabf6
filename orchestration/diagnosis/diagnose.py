"""From files of measurements to a diagnosis, for commands and notebooks, and the next experiment as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import Answer, remark
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.doubtful import doubts
from warmlink.orchestration.diagnosis.answer.entries import cause_entry, json_content
from warmlink.orchestration.diagnosis.answer.extension import extended_values
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.data.columns import NOTHING_SAID, Said
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_runs
from warmlink.orchestration.diagnosis.data.inputs import parameters_of, with_inputs, with_noise, with_nominal
from warmlink.orchestration.diagnosis.data.rig import Rig
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess, fitted_part
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.practice.hide import demand_columns, write_csv
from warmlink.orchestration.progress import Progress, spinner, stretch, unseen
from warmlink.orchestration.scenarios.duties.duty import length
from warmlink.orchestration.scenarios.quantities import heading
from warmlink.orchestration.threads import one_thread

_ASSESSED, _HELD_OUT = 0.8, 0.85
"""Shares of the work that are usually done after the search and after the held-out rows."""

_ANSWER = {
    "columns that may be something else": "doubts",
    "heat that is missing": "missing_heat",
    "compensation by the model": "feed_forward",
    "compensation by an observer": "observer",
    "other duty cycles": "claims",
    "next experiment": "proposed",
}
"""What an answer asks for, and where a diagnosis has it."""

SCENARIO, DUTY = "next_experiment.toml", "next_experiment.csv"
"""Files of a proposed duty cycle: a scenario that `run` and `hide` take, and its rows."""


def read(
    sources: Sequence[Path | str | pd.DataFrame],
    assumed: Sequence[str] = (),
    settings: Mapping[str, str] = MappingProxyType({}),
    told: Said = NOTHING_SAID,
) -> Experiment:
    """What a diagnosis works on, of measured runs together or of an experiment.

    Parameters
    ----------
    sources : an experiment file (TOML), or files or DataFrames measured on one warm-up cell
    assumed : `NAME=VALUE` of inputs that were not logged
    settings : values with units of parameters by which the system differs from the nominal one
    told : units and names of columns that the user gave

    Raises
    ------
    InputError
        A file, or something in it, cannot be used.
    """
    experiment = read_runs([Path(each) if isinstance(each, str) else each for each in sources], told)
    return with_inputs(with_nominal(experiment, settings), assumed)


def diagnose_experiment(experiment: Experiment, progress: Progress = unseen) -> Diagnosis:
    """Diagnose an experiment that was read or made."""
    with one_thread():
        refuse_senseless(experiment)
        assessment = _assessed(experiment, stretch(progress, 0.0, _ASSESSED))
        progress("held-out rows", _ASSESSED)
        found = Diagnosis(experiment, assessment)
        _ = found.held_out  # found when it is asked for, and that is now, while progress is shown
    return found


def work_out(found: Diagnosis, progress: Progress) -> None:
    """Work out now, while progress is shown, what an answer of a diagnosis will ask for."""
    with one_thread():
        for k, (doing, part) in enumerate(_ANSWER.items()):
            progress(doing, _HELD_OUT + (1.0 - _HELD_OUT) * k / len(_ANSWER))
            getattr(found, part)


def _assessed(experiment: Experiment, progress: Progress) -> Assessment:
    """What a search finds; where the model as it stands cannot be simulated, an input is perhaps to blame."""
    try:
        return assess(experiment, progress)
    except NotSimulatedError as fault:
        problem = Problem(fitted_part(experiment))
        for doubt in doubts(problem, problem.neutral):
            raise InputError(f"{fault}; {doubt}") from None
        raise


@dataclass(frozen=True, repr=False)
class Found(Answer):
    """What a simulation gets wrong, and why."""

    diagnosis: Diagnosis

    @property
    def verdict(self) -> str:
        """One of adequate, named, ambiguous, empirical, unknown."""
        return self.diagnosis.verdict

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes found, strongest first."""
        return tuple(item.title for item in self.diagnosis.causes)

    @property
    def extended(self) -> dict[str, float]:
        """Parameters of the extended model that differ from nominal, in SI units; `run` takes them."""
        return extended_values(self.diagnosis.assessment.problem, self.diagnosis.adopted.fit)

    def summary(self) -> str:
        """At most ten lines of plain words."""
        return summary(self.diagnosis)

    def to_dict(self) -> dict[str, Any]:
        """What stands in `diagnosis.json`."""
        return json_content(self.diagnosis)

    def to_frame(self) -> pd.DataFrame:
        """A row for each parameter of the causes found: value, unit and 95 % interval."""
        entries = [cause_entry(self.diagnosis, item) for item in self.diagnosis.causes]
        rows = [
            {"cause": entry["name"], "parameter": name, **figures}
            for entry in entries
            for name, figures in entry["parameters"].items()
        ]
        return pd.DataFrame(rows, columns=["cause", "parameter", "value", "std", "low95", "high95", "unit"])


def diagnose(
    *sources: str | Path | pd.DataFrame,
    assume: Mapping[str, str | float] = MappingProxyType({}),
    parameters: Mapping[str, str] = MappingProxyType({}),
    scenario: str | Path | None = None,
    noise: Mapping[str, str] = MappingProxyType({}),
    units: Mapping[str, str] = MappingProxyType({}),
    names: Mapping[str, str] = MappingProxyType({}),
    decimal: str = "",
) -> Found:
    """Show what the simulation gets wrong and name the cause.

    Parameters
    ----------
    sources : files or DataFrames measured on one warm-up cell, with columns as `tip_temperature [degC]`; or
        an experiment (TOML)
    assume : inputs that were not logged, as `{"torque": 0, "ambient_temperature": "22 degC"}`
    parameters : what is known to differ from nominal, `"800 mm"` under `link.length`
    scenario : a scenario (TOML) of the cell as it is known
    noise : 1 sigma by column or variable, `"0.1 K"` under `tip_temperature`
    units : those that headers lack, `"degC"` under `T_base`
    names : what columns are, `"base_temperature"` under `T_base`; "" leaves the column out
    decimal : decimal mark, "point" or "comma", if a file could be read either way

    Raises
    ------
    InputError
        If a source, or something in it, cannot be used.
    """
    known = {} if scenario is None else parameters_of(str(scenario))
    assumed = [f"{name}={value}" for name, value in assume.items()]
    with spinner("Diagnosing") as progress:
        progress("reading")
        told = Said(units, names=names, decimal=decimal)
        experiment = with_noise(read(sources, assumed, {**known, **parameters}, told), noise)
        found = Found(diagnose_experiment(experiment, progress))
        work_out(found.diagnosis, progress)
    for each in found.diagnosis.remarks:
        remark(each)
    return found


def write_next(proposed: Proposed, rig: Rig, known: Mapping[str, float], folder: Path) -> None:
    """Write the proposed duty cycle as `next_experiment.toml` and `next_experiment.csv`.

    Parameters
    ----------
    proposed : with a duty cycle
    rig : the system
    known : values in SI by variable in which it differs from the nominal one
    folder : where to
    """
    (folder / SCENARIO).write_text(_scenario(proposed, rig, known), encoding="utf-8")
    # A row where each segment begins, and one at the end.
    rows = np.cumsum([0.0, *(segment.duration for segment in proposed.duty)])
    write_csv(demand_columns(rows, proposed.duty), folder / DUTY)


def _scenario(proposed: Proposed, rig: Rig, known: Mapping[str, float]) -> str:
    cycle, rounds = proposed.cycle
    why = proposed.why.replace("\\", "").replace('"""', "")
    both = "Run it on the machine, and diagnose both: warmlink diagnose RUN.csv NEXT.csv"
    lines = ['title = "The next experiment"', f'reason = """\n{why}\n{both}\n"""']
    lines.append(f'stop_time = "{length(proposed.duty):.10g} s"')
    lines += ["repeat = true"] if rounds > 1 else []
    begins = np.cumsum([0.0, *(segment.duration for segment in cycle)])
    demands = [(*heading(header), each) for header, each in demand_columns(begins, cycle).items()]
    for i, segment in enumerate(cycle):
        lines += ["\n[[segment]]", f'duration = "{segment.duration:.10g} s"']
        here = [(name, unit, each[i]) for name, unit, each in demands[1:] if np.isfinite(each[i])]
        lines += [f'{name} = "{value:.10g} {unit}"' for name, unit, value in here]
    plant = {name: value for name, value in known.items() if name in rig.parameters}
    if plant:
        lines.append("\n[parameters]")
        lines += [f'"{name}" = "{value!r} {rig.unit(name)}"' for name, value in plant.items()]
    return "\n".join(lines) + "\n"
