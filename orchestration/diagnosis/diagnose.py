"""From files of measurements to a diagnosis, and the next experiment as files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.doubtful import doubts
from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_runs
from warmlink.orchestration.diagnosis.data.inputs import with_inputs, with_nominal
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.fit.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.fit.verdict import Assessment, assess, fitted_part
from warmlink.orchestration.diagnosis.known_values import asked
from warmlink.orchestration.diagnosis.model.simulation import NotSimulatedError
from warmlink.orchestration.diagnosis.practice.hide import demand_columns, write_csv
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.progress import Progress, stretch, unseen
from warmlink.orchestration.scenarios.duties.duty import length
from warmlink.orchestration.threads import one_thread
from warmlink.orchestration.written.quantities import heading

_ASSESSED, _HELD_OUT = 0.8, 0.85
"""Shares of the work that are usually done after the search and after the held-out rows."""

_ANSWER = {
    "columns that may be something else": "doubts",
    "models beside plain fits": "ladder",
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
    options: ReadOptions = DEFAULT_OPTIONS,
) -> Experiment:
    """What a diagnosis works on, of measured runs together or of an experiment.

    Parameters
    ----------
    sources : an experiment file (TOML), or files or DataFrames measured on one warm-up cell
    assumed : `NAME=VALUE` of inputs that were not logged
    settings : values with units of parameters by which the system differs from the nominal one
    options : units and names of columns that the user gave

    Raises
    ------
    InputError
        A file, or something in it, cannot be used.
    """
    experiment = read_runs([Path(each) if isinstance(each, str) else each for each in sources], options)
    return with_inputs(with_nominal(experiment, settings), assumed)


def diagnose_experiment(experiment: Experiment, progress: Progress = unseen) -> Diagnosis:
    """Diagnose an experiment that was read or made."""
    with one_thread():
        refuse_senseless(experiment)
        search = stretch(progress, 0.0, _ASSESSED)
        known = asked(experiment, _assessed(experiment, search), search)
        progress("held-out rows", _ASSESSED)
        found = Diagnosis(known.experiment, known.assessment, known.would_help)
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
    lines = [] if rig.source is None else [f"system = {json.dumps(str(rig.source.resolve()))}"]
    lines += ['title = "The next experiment"', f'reason = """\n{why}\n{both}\n"""']
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
