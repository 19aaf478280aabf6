"""`warmlink run`: a scenario in closed loop, its answer, its files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.library import is_arm_scenario
from warmlink.orchestration.commands.console import answer, answer_json, progress_bar, remark
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuKind, store
from warmlink.orchestration.report.series import write_series
from warmlink.orchestration.scenarios.closed_loop import NO_CONTROLLER, ClosedLoop, run_scenario
from warmlink.orchestration.scenarios.metrics import ErrorMetrics
from warmlink.orchestration.scenarios.overrides import StartValueSet
from warmlink.orchestration.scenarios.parameter_files import parameters_of
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.scenario import Scenario, load_scenario
from warmlink.orchestration.system.shipped import WARMUP_CELL

STOPPED_EARLY = 1


def run_command(
    name: str,
    controller: str | None,
    fmus: str | None,
    out: Path | None,
    settings: list[str],
    parameter_files: list[Path],
    step: str | None,
    stop: str | None,
    master: str | None,
    report: bool,
    as_json: bool,
) -> int:
    """Run, write and answer; gives the exit code."""
    given = start_values_given(parameter_files, settings)
    if is_arm_scenario(name):
        from warmlink.orchestration.commands.run_arm import run_arm_command

        kind = chosen_kind(fmus)
        return run_arm_command(name, controller, kind, out, given, step, stop, master, report, as_json)
    scenario = _scenario(name, given, step, stop, master)
    controller = controller or scenario.controller
    laws = {catalogue.controller(law).name for law in (controller, NO_CONTROLLER)}
    needed = {kind for law in laws for kind in WARMUP_CELL.components_with(law).values()}
    fmu_store = store(chosen_kind(fmus), sorted(needed), remark)
    folder = out or Path("out") / scenario.name
    with fresh_folder(folder) as target:
        with progress_bar(scenario.title) as progress:
            outcome = run_scenario(scenario, controller, fmu_store, progress)
        (target / "metrics.json").write_text(json.dumps(outcome.to_dict(), indent=2) + "\n")
        write_series(outcome.compensated, target)
        if report:
            from warmlink.orchestration.report.closed_loop import write_report

            write_report(outcome, target / "report.html")
    if as_json:
        answer_json(outcome.to_dict())
    else:
        answer(_answer(outcome))
        answer(f"{'report' if report else 'results'}  {folder / 'report.html' if report else folder}")
    if outcome.stopped is not None:
        remark(f"stopped early: {outcome.stopped}; what was computed up to there is kept")
        return STOPPED_EARLY
    return 0


def _scenario(
    name: str,
    given: dict[str, str | float],
    step: str | None,
    stop: str | None,
    master: str | None,
) -> Scenario:
    scenario = load_scenario(name)
    if step is not None:
        scenario = replace(scenario, step_size=positive(step, "s", "--step"))
    if stop is not None:
        duty = replace(scenario.duty, stop_time=positive(stop, "s", "--stop"))
        scenario = replace(scenario, duty=duty)
    if master is not None:
        scenario = replace(scenario, master=master)
    return replace(scenario, parameters={**scenario.parameters, **given})


def start_values_given(parameter_files: list[Path], settings: list[str]) -> dict[str, str | float]:
    """Start values by name from `--parameters` and from `--set`, which comes last."""
    given: dict[str, str | float] = {}
    for each in start_value_sets(parameter_files, settings):
        given |= each.values
    return given


def start_value_sets(parameter_files: list[Path], settings: list[str]) -> list[StartValueSet]:
    """Start values of each `--parameters` and of each `--set`, which come last."""
    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in parameter_files]
    return sets + [StartValueSet(f"--set {each}", settings_given([each])) for each in settings]


def settings_given(settings: list[str]) -> dict[str, str]:
    """Start values by name, as `--set` has them; raises InputError where one has no value."""
    parameters = {}
    for setting in settings:
        variable, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f'--set {setting}: no value; write --set "motor.joint_conductance=2 W/K"')
        parameters[variable.strip()] = value.strip()
    return parameters


def chosen_kind(name: str | None) -> FmuKind | None:
    """Kind of FMU by its name, None unasked; raises InputError where there is none of that name."""
    for kind in FMU_KINDS:
        if kind == name:
            return kind
    if name is not None:
        raise InputError(f"--fmus {name}: no such kind; choose {' or '.join(FMU_KINDS)}")
    return None


def _answer(outcome: ClosedLoop) -> str:
    scenario, before, after = outcome.scenario, outcome.uncompensated, outcome.metrics
    tolerance = 1e6 * scenario.tolerance
    removed = outcome.to_dict()["reduction_percent"]
    share = "" if removed is None else _removed(removed)
    coupling = "unknown" if outcome.coupling_error_um is None else f"±{outcome.coupling_error_um:.2g} µm"
    rows = [
        ("", NO_CONTROLLER, outcome.controller, ""),
        ("largest error", f"{before.max_abs_um:.1f} µm", f"{after.max_abs_um:.1f} µm", share),
        (f"within ±{tolerance:g} µm from", _settled(before), _settled(after), ""),
        ("coupling error", coupling, coupling, ""),
    ]
    head = (
        f"{scenario.name} · {_duration(scenario.stop_time)} · {outcome.fmus} FMUs · "
        f"{scenario.step_size:g} s steps · {scenario.master}"
    )
    return "\n".join([head, *(f"{a:<20}{b:>14}{c:>15}     {d}".rstrip() for a, b, c, d in rows)])


def _removed(percent: float) -> str:
    return f"{percent:.0f} % removed" if percent >= 0 else f"{-percent:.0f} % worse"


def _settled(metrics: ErrorMetrics) -> str:
    if metrics.time_to_tolerance_s is None:
        return "never"
    return "start" if metrics.time_to_tolerance_s == 0 else _duration(metrics.time_to_tolerance_s)


def _duration(seconds: float) -> str:
    if seconds >= 3600:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 60 else f"{seconds:.3g} s"
