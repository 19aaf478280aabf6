"""The next experiment as files: a scenario that `run` and `hide` take, and its duty cycle as rows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warmlink.orchestration.diagnosis.practice.hide import demand_columns, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment, length
from warmlink.orchestration.system.units import ZERO_CELSIUS

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.answer.next_experiment import Proposed
    from warmlink.orchestration.diagnosis.data.rig import Rig

SCENARIO, DUTY = "next_experiment.toml", "next_experiment.csv"


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
    lines = [
        'title = "The next experiment"',
        f'reason = """\n{why}\n{both}\n"""',
        f'stop_time = "{length(proposed.duty):.10g} s"',
        *(["repeat = true"] if rounds > 1 else []),
        *(_segment(segment) for segment in cycle),
    ]
    plant = {name: value for name, value in known.items() if name in rig.parameters}
    if plant:
        lines.append("\n[parameters]")
        lines += [f'"{name}" = "{value!r} {rig.unit(name)}"' for name, value in plant.items()]
    return "\n".join(lines) + "\n"


def _segment(segment: Segment) -> str:
    pad = "" if np.isnan(segment.pad) else f'\npad_temperature = "{segment.pad - ZERO_CELSIUS:.10g} degC"'
    return (
        f'\n[[segment]]\nduration = "{segment.duration:.10g} s"\nspeed = "{segment.speed:.10g} rad/s"\n'
        f'torque = "{segment.torque:.10g} N.m"\n'
        f'ambient_temperature = "{segment.ambient_temperature - ZERO_CELSIUS:.10g} degC"{pad}'
    )
