"""`warmlink run` for the arm: its answer, its files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from warmlink.orchestration.arm.compensation import DESIGNED
from warmlink.orchestration.arm.outcome import ArmOutcome
from warmlink.orchestration.arm.run import arm_kinds, run_arm
from warmlink.orchestration.arm.scenario import ArmScenario, load_arm_scenario
from warmlink.orchestration.commands.console import answer, answer_json, progress_bar, remark
from warmlink.orchestration.files import fresh_folder, write_files
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.report.series import series_writers
from warmlink.orchestration.scenarios.closed_loop import NO_CONTROLLER
from warmlink.orchestration.scenarios.metrics import ErrorMetrics, reduction_percent
from warmlink.orchestration.scenarios.quantity import positive

STOPPED_EARLY = 1


def run_arm_command(
    name: str,
    controller: str | None,
    fmus: FmuKind | None,
    out: Path | None,
    settings: dict[str, str | float],
    step: str | None,
    stop: str | None,
    master: str | None,
    report: bool,
    as_json: bool,
) -> int:
    """Run, write and answer; gives the exit code."""
    scenario = _scenario(name, settings, step, stop, master)
    controller = controller or scenario.controller
    needed = arm_kinds(controller)
    if controller not in DESIGNED:
        remark(
            f"{controller} has no design for the arm's axes; it runs with the parameters of the warm-up cell"
        )
    fmu_store = store(fmus, needed, remark)
    folder = out or Path("out") / scenario.name
    with fresh_folder(folder) as target:
        with progress_bar(scenario.title) as progress:
            outcome = run_arm(scenario, controller, fmu_store, progress)
        metrics = json.dumps(outcome.to_dict(), indent=2) + "\n"
        writers = series_writers(outcome.result)
        writers["metrics.json"] = lambda path: path.write_text(metrics)
        if report:
            from warmlink.orchestration.report.arm import write_report

            writers["report.html"] = lambda path: write_report(outcome, path)
        lost = write_files(target, writers)
    if as_json:
        answer_json(outcome.to_dict())
    else:
        answer(_answer(outcome))
        answer(f"{'report' if report else 'results'}  {folder / 'report.html' if report else folder}")
    if lost is not None:
        remark(f"{folder}: {lost}")
    if outcome.stopped is not None:
        remark(f"stopped early: {outcome.stopped}; what was computed up to there is kept")
        remark("the figures are of that part alone")
    return 0 if lost is None and outcome.stopped is None else STOPPED_EARLY


def _scenario(
    name: str, settings: dict[str, str | float], step: str | None, stop: str | None, master: str | None
) -> ArmScenario:
    scenario = load_arm_scenario(name)
    scenario = replace(scenario, parameters={**scenario.parameters, **settings})
    if step is not None:
        scenario = replace(scenario, step_size=positive(step, "s", "--step"))
    if stop is not None:
        program = replace(scenario.program, stop_time=positive(stop, "s", "--stop"))
        scenario = replace(scenario, program=program)
    return scenario if master is None else replace(scenario, master=master)


def _answer(outcome: ArmOutcome) -> str:
    scenario, before = outcome.scenario, outcome.metrics()
    head = (
        f"{scenario.name} · {_duration(scenario.stop_time)} · {outcome.fmus} FMUs · "
        f"{scenario.step_size:g} s steps · {scenario.master} · {scenario.sensor} thermometers"
    )
    kinds = [None, *(each.correction for each in outcome.compensations)]
    metrics = [before, *(outcome.metrics(each) for each in kinds[1:])]
    largest = [1e6 * np.abs(outcome.tool_error(each)).max(axis=0) for each in kinds]
    coupling = outcome.coupling_error_um
    rows = [
        ("", NO_CONTROLLER, *(each.name for each in outcome.compensations)),
        ("largest tool-point error", *(f"{each.max_abs_um:.1f} µm" for each in metrics)),
        ("in x, y and z", *("/".join(f"{value:.1f}" for value in each) for each in largest)),
        ("removed", "", *(_removed(before, each) for each in metrics[1:])),
        (f"within {1e6 * scenario.tolerance:g} µm from", *(_settled(each) for each in metrics)),
        ("coupling error", "unknown" if coupling is None else f"±{coupling:.2g} µm"),
    ]
    lines = [f"{row[0]:<26}" + "".join(f"{cell:>18}" for cell in row[1:]) for row in rows]
    return "\n".join([head, *(line.rstrip() for line in lines)])


def _removed(before: ErrorMetrics, after: ErrorMetrics) -> str:
    percent = reduction_percent(before, after)
    return "" if percent is None else f"{percent:.1f} %"


def _settled(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else _duration(metrics.time_to_tolerance_s)


def _duration(seconds: float) -> str:
    if seconds >= 3600:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 60 else f"{seconds:.3g} s"
