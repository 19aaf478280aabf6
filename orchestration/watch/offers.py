"""What an alarm offers: the rows it rests on, and new parameters of model and law. Nothing is applied."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.experiment_file import MEASURED
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.system.ssp.parameter_values import SsvValue, write_ssv
from warmlink.orchestration.system.units import parse_unit
from warmlink.orchestration.watch.hypotheses import WatchedMachine
from warmlink.orchestration.watch.learning import SoundPart
from warmlink.orchestration.watch.naming import Explanation
from warmlink.orchestration.watch.ticks import Tick

WINDOW_FILE, EXPERIMENT_FILE, MODEL_FILE, LAW_FILE = "window.csv", "experiment.toml", "model.ssv", "law.ssv"
"""Files of an alarm."""

_SAME = 1e-9
"""Share by which a value differs from the nominal one if it was calibrated."""

Design = Callable[[Mapping[str, float], Path], None]
"""Designs the law for parameters of the plant in SI by name, and writes its parameter set."""


def write_offer(
    folder: Path,
    system: str,
    machine: WatchedMachine,
    learnt: SoundPart,
    ticks: Sequence[Tick],
    causes: Sequence[Explanation],
    design: Design | None,
) -> list[str]:
    """Write what an alarm offers; give the names of the files.

    Parameters
    ----------
    folder : of the alarm, made if it is not there
    system : the machine as an experiment names it: a name, or the absolute path of a file
    machine : what is watched
    learnt : of the sound part
    ticks : on which the alarm rests
    causes : that explain it, best first
    design : of the law, None if no law of ours is judged

    Raises
    ------
    InputError
        A file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with fresh_file(folder / WINDOW_FILE) as scratch:
            _write_window(scratch, machine, ticks)
        with fresh_file(folder / EXPERIMENT_FILE) as scratch:
            scratch.write_text(_experiment(system, machine, learnt), "utf-8")
        files = [WINDOW_FILE, EXPERIMENT_FILE]
        changed = changed_parameters(machine, learnt, causes if causes or design is None else None)
        if changed is not None:
            units = {name: machine.rig.unit(name) for name in changed}
            held = {
                name: SsvValue(name, "Real", value, None if units[name] == "1" else parse_unit(units[name]))
                for name, value in changed.items()
            }
            with fresh_file(folder / MODEL_FILE) as scratch:
                write_ssv(held, scratch, "model, offered")
            files.append(MODEL_FILE)
    except OSError as fault:
        raise InputError(f"{folder}: cannot be written ({fault.strerror}); choose another folder") from None
    if changed is not None and design is not None:
        try:
            design(changed, folder / LAW_FILE)
        except InputError:
            return files  # the law has no design, or none for such a machine
        files.append(LAW_FILE)
    return files


def changed_parameters(
    machine: WatchedMachine, learnt: SoundPart, causes: Sequence[Explanation] | None
) -> dict[str, float] | None:
    """The model's parameters in SI that differ from nominal: as calibrated, and as the best cause says.

    None if the best cause is none of the model's parameters, or unknown; without causes (None) those that
    were calibrated.
    """
    slots, values = machine.equations.slots, learnt.values.copy()
    if causes is not None:
        if not causes or not any(slots[i] in machine.rig.parameters for i in causes[0].hypothesis.slots):
            return None
        values[list(causes[0].hypothesis.slots)] += causes[0].value
    for each in machine.hypotheses:  # a search within bounds may end a hair beyond one
        at = list(each.slots)
        values[at] = np.clip(values[at], each.lower, each.upper)
    moved = np.abs(values - machine.slots) > _SAME * (1 + np.abs(machine.slots))
    there = dict(zip(slots, values.tolist(), strict=True))
    calibrated = {n: there[n] for n, m in zip(slots, moved, strict=True) if m and n in machine.rig.parameters}
    return {**machine.known, **calibrated}


def _experiment(system: str, machine: WatchedMachine, learnt: SoundPart) -> str:
    """The window as an experiment of the model as it was calibrated, which `diagnose` takes."""
    known = changed_parameters(machine, learnt, None) or {}
    units = {name: "" if machine.rig.unit(name) == "1" else f" {machine.rig.unit(name)}" for name in known}
    return "\n".join(
        [
            "# What led to the alarm; the model as it was calibrated on the sound part.",
            f"system = {json.dumps(system)}",
            f"initial = {json.dumps(MEASURED)}",
            "",
            "[[run]]",
            f"data = {json.dumps(WINDOW_FILE)}",
            "",
            "[known]",
            *(f'{json.dumps(name)} = "{value!r}{units[name]}"' for name, value in known.items()),
            "",
        ]
    )


def _write_window(path: Path, machine: WatchedMachine, ticks: Sequence[Tick]) -> None:
    """Means of the ticks, in SI, with columns as `diagnose` takes them."""
    rig, names = machine.rig, machine.names
    columns = [*machine.inputs, *machine.outputs]
    fed = [rig.externals.index(name) for name in machine.inputs]
    with path.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["time [s]", *(f"{names[each]} [{rig.unit(each)}]" for each in columns)])
        for tick in ticks:
            means = np.append((tick.shares @ tick.levels)[fed], tick.readings).tolist()
            cells = ("" if np.isnan(value) else repr(value) for value in means)
            table.writerow([repr((tick.start + tick.end) / 2), *cells])
