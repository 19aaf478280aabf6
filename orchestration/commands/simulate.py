"""`warmlink simulate`: anybody's system of FMUs."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.commands.console import answer, answer_json, progress_bar, remark
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.master.algorithms import algorithm
from warmlink.orchestration.master.result import Result
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.report.series import write_series
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.system.model import DefaultExperiment
from warmlink.orchestration.system.read import read_system

STOPPED_EARLY = 1
DEFAULT_STEPS = 500


def simulate_command(
    path: Path, stop: str | None, step: str | None, master: str, out: Path | None, as_json: bool
) -> int:
    """Run, write and answer; gives the exit code."""
    chosen = algorithm(master)
    with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
        system = read_system(path, Path(work))
        for told in system.remarks:
            remark(told)
        experiment = _experiment(system.default_experiment, stop, step, path)
        assert experiment.stop_time is not None
        assert experiment.step_size is not None
        with progress_bar(system.name) as progress:
            result = simulate(
                system,
                experiment.stop_time,
                experiment.step_size,
                chosen,
                start_time=experiment.start_time,
                progress=lambda done, count: progress(done / count),
            )
    folder = out or Path("out") / path.stem
    with fresh_folder(folder) as target:
        write_series(result, target)
    if as_json:
        answer_json(_summary(result, folder))
    else:
        _print_summary(result, f"{system.name} · {experiment.step_size:g} s steps · {master}", folder)
    if result.reason is not None:
        remark(f"stopped early: {result.reason}; what was computed up to there is kept")
        return STOPPED_EARLY
    return 0


def _experiment(
    proposed: DefaultExperiment, stop: str | None, step: str | None, path: Path
) -> DefaultExperiment:
    stop_time = proposed.stop_time if stop is None else positive(stop, "s", "--stop")
    if stop_time is None:
        raise InputError(f'{path}: the system proposes no stop time; give one, as --stop "1 h"')
    step_size = proposed.step_size if step is None else positive(step, "s", "--step")
    return replace(proposed, stop_time=stop_time, step_size=step_size or stop_time / DEFAULT_STEPS)


def _summary(result: Result, folder: Path) -> dict[str, Any]:
    return {
        "stop_time_s": float(result.times[-1]) if len(result.times) else None,
        "stopped": result.reason,
        "results": str(folder),
        "outputs": {
            name: {
                "unit": result.table.units[name],
                "last": float(result[name][-1]),
                "min": float(result[name].min()),
                "max": float(result[name].max()),
            }
            for name in result.table.names
            if len(result.times)
        },
    }


def _print_summary(result: Result, head: str, folder: Path) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=head, title_justify="left", box=None)
    for heading in ("output", "unit", "last", "least", "largest"):
        table.add_column(heading, justify="left" if heading in ("output", "unit") else "right")
    for name, figures in _summary(result, folder)["outputs"].items():
        cells = (f"{figures[key]:.6g}" for key in ("last", "min", "max"))
        table.add_row(name, figures["unit"] or "1", *cells)
    Console().print(table)
    answer(f"results  {folder}")
