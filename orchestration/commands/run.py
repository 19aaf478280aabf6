"""`warmlink run`: a scenario in closed loop, its answer, its files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.command_line.console import FAILED, answer, answer_json, progress_bar, remark
from warmlink.orchestration.files import fresh_folder, write_files
from warmlink.orchestration.fmu_store import FMU_KINDS, FmuKind, store
from warmlink.orchestration.master.pacing import Interruption
from warmlink.orchestration.own_law import is_own_law, load_own_law
from warmlink.orchestration.report.series import series_writers
from warmlink.orchestration.scenarios.closed_loop import ClosedLoop, run_scenario
from warmlink.orchestration.scenarios.load import load_scenario
from warmlink.orchestration.scenarios.metrics import ErrorMetrics
from warmlink.orchestration.scenarios.overrides import StartValueSet
from warmlink.orchestration.scenarios.parameter_files import parameters_of
from warmlink.orchestration.scenarios.quantity import positive
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.studies import mismatch


@dataclass(frozen=True)
class RunOptions:
    """What the command line says; times as written, as `"1 h"`, None for what the scenario says.

    Attributes
    ----------
    scenario : name or file
    controller : name, or the place of a law of one's own, as `my_law.py:MyLaw`
    fmus : kind of FMU
    out : folder for results; None for one under `out`
    settings : start values, as `motor.joint_conductance=2 W/K`
    parameter_files : parameter sets (SSV)
    mismatches : names or files, one on top of the other
    master : name of the algorithm
    report : whether to write the page
    """

    scenario: str
    controller: str | None = None
    fmus: str | None = None
    out: Path | None = None
    settings: tuple[str, ...] = ()
    parameter_files: tuple[Path, ...] = ()
    mismatches: tuple[str, ...] = ()
    step: str | None = None
    stop: str | None = None
    master: str | None = None
    report: bool = True


def run_command(options: RunOptions, as_json: bool) -> int:
    """Run, write and answer; gives the exit code."""
    scenario = _scenario(options, start_values_given(options.parameter_files, options.settings))
    own = load_own_law(scenario.controller) if is_own_law(scenario.controller) else None
    law = catalogue.controller(scenario.controller) if own is None else own.component
    for name in options.mismatches:
        scenario = mismatch.load(name).applied(scenario, law)
    needed = scenario.setup.kinds([law]) - ({law.name} if own else set())
    fmu_store = store(chosen_kind(options.fmus), sorted(needed), remark)
    folder = options.out or Path("out") / scenario.name
    with fresh_folder(folder) as target:
        with progress_bar(scenario.title) as progress:
            name = scenario.controller if own is None else own.name
            outcome = run_scenario(scenario, name, fmu_store, progress, own)
        if outcome.time.size == 0:
            remark(f"{outcome.cut_short}; there are no results")
            return FAILED
        with Interruption():  # a Ctrl-C now does not cost what was computed
            lost = _write(outcome, target, options.report)
    if as_json:
        answer_json(outcome.to_dict())
    else:
        answer(_answer(outcome))
        answer(f"report  {folder / 'report.html'}" if options.report else f"results  {folder}")
    if lost is not None:
        remark(f"{folder}: {lost}")
    if outcome.cut_short is not None:
        remark(f"stopped early: {outcome.cut_short}; what was computed up to there is kept")
        remark("the figures are of that part alone")
    return 0 if lost is None and outcome.cut_short is None else FAILED


def _scenario(options: RunOptions, given: dict[str, str | float]) -> Scenario:
    scenario = load_scenario(options.scenario)
    duty = scenario.duty
    if options.stop is not None:
        duty = duty.until(positive(options.stop, "s", "--stop"))
    return replace(
        scenario,
        duty=duty,
        step_size=scenario.step_size if options.step is None else positive(options.step, "s", "--step"),
        master=options.master or scenario.master,
        controller=options.controller or scenario.controller,
        parameters={**scenario.parameters, **given},
    )


def _write(outcome: ClosedLoop, target: Path, report: bool) -> str | None:
    """Write what came of the run; give what could not be written and why."""
    metrics = json.dumps(outcome.to_dict(), indent=2) + "\n"
    writers = {
        "metrics.json": lambda path: path.write_text(metrics, encoding="utf-8"),
        **series_writers(outcome.result),
    }
    if report:
        from warmlink.orchestration.report.closed_loop import write_report

        writers["report.html"] = lambda path: write_report(outcome, path)
    return write_files(target, writers)


def start_values_given(parameter_files: Sequence[Path], settings: Sequence[str]) -> dict[str, str | float]:
    """Start values by name from `--parameters` and from `--set`, which comes last."""
    given: dict[str, str | float] = {}
    for each in start_value_sets(parameter_files, settings):
        given |= each.values
    return given


def start_value_sets(parameter_files: Sequence[Path], settings: Sequence[str]) -> list[StartValueSet]:
    """Start values of each `--parameters` and of each `--set`, which come last."""
    sets = [StartValueSet(f"--parameters {path}", parameters_of(path)) for path in parameter_files]
    return [*sets, *(StartValueSet(f"--set {each}", settings_given([each])) for each in settings)]


def settings_given(settings: Sequence[str]) -> dict[str, str]:
    """Start values by name, as `--set` has them; raises InputError where one has no value."""
    parameters = {}
    for setting in settings:
        variable, equals, value = setting.partition("=")
        if not equals or not variable.strip():
            missing = "no name" if equals else "no value"
            raise InputError(f'--set {setting}: {missing}; write --set "motor.joint_conductance=2 W/K"')
        parameters[variable.strip()] = value.strip()
    return parameters


def chosen_kind(name: str | None) -> FmuKind | None:
    """Kind of FMU by its name, None unasked; raises InputError where there is none of that name."""
    for kind in FMU_KINDS:
        if kind == name:
            return kind
    if name is not None:
        raise InputError(f"--fmus {name}: no such kind; {instead(name, FMU_KINDS)}")
    return None


def _answer(outcome: ClosedLoop) -> str:
    scenario, before, after = outcome.scenario, outcome.uncompensated, outcome.metrics
    tolerance = 1e6 * scenario.tolerance
    removed = outcome.reduction_percent
    share = "" if removed is None else _removed(removed)
    coupling = "unknown" if outcome.coupling_error_um is None else f"±{outcome.coupling_error_um:.2g} µm"
    rows = [
        ("", NO_CONTROLLER, outcome.controller, ""),
        ("largest error", f"{before.max_abs_um:.1f} µm", f"{after.max_abs_um:.1f} µm", share),
        (f"within ±{tolerance:g} µm from", _settled(before), _settled(after), ""),
        ("coupling error", coupling, coupling, ""),
    ]
    done, whole = float(outcome.time[-1]), _duration(scenario.stop_time)
    parts = (
        scenario.name,
        *scenario.mismatches,
        whole if done >= scenario.stop_time else f"{_duration(done)} of {whole}",
        f"{outcome.fmus} FMUs",
        f"{scenario.step_size:g} s steps",
        scenario.master,
    )
    lines = [f"{a:<20}{b:>14}{c:>15}     {d}".rstrip() for a, b, c, d in rows]
    return "\n".join([" · ".join(parts), *lines, *(f"note  {text}" for text in outcome.remarks)])


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
