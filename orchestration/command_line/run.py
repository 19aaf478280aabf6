"""`warmlink run`: run a scenario in closed loop, print the answer and write the files."""

from __future__ import annotations

import json as json_text
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.orchestration.command_line import arguments
from warmlink.orchestration.console import FAILED, answer, answer_json, remark
from warmlink.orchestration.files import locked_folder, write_files
from warmlink.orchestration.results import refuse_others, results_folder, results_in

COMMANDS = ("run",)

LIVE_PAGE = "live.html"

if TYPE_CHECKING:
    from warmlink.orchestration.closed_loop.outcome import ClosedLoop
    from warmlink.orchestration.fmu_store import FmuKind
    from warmlink.orchestration.report.live.content import Asked
    from warmlink.orchestration.scenarios.scenario import Scenario


def run(
    scenario: str = "warm_up",
    *,
    controller: str | None = None,
    variant: str | None = None,
    fmus: str | None = None,
    out: Path | None = None,
    set_: list[str] | None = None,
    parameters: list[Path] | None = None,
    mismatch: list[str] | None = None,
    step: str | None = None,
    stop: str | None = None,
    master: str | None = None,
    tolerance: str | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    statistics: bool = False,
    record: str | None = None,
    csv: bool = True,
    report: bool = True,
    json: bool = False,
) -> None:
    """Run a scenario with a controller and without one, and say how far off the tool point is.

    Writes metrics.json, results.csv, results.parquet and report.html, which holds the page of `warmlink live`
    where that was compiled for the system before. If you press Ctrl-C, the process is told to end (SIGTERM),
    or an FMU fails, the run ends early and keeps what was computed up to there (exit code 1).

    Parameters
    ----------
    controller : Controller to compare with no compensation, or a law of your own, as `my_law.py:MyLaw`.
        Default: the one that the scenario names.
    out : Folder for results. Default: out/SCENARIO.
    mismatch : How the real cell differs from the one that the controller was designed for: `thermal_high`,
        `noisy_sensors`, `draw_1` and so on (`warmlink list`), or a TOML file. Repeatable; several mismatches
        add up.
    step : Communication step size, such as "1 s".
    stop : Stop time, such as "2 h".
    """
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.closed_loop.outcome import run as run_in_closed_loop
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.master.slaves.under_way import interruption
    from warmlink.orchestration.report.plot import ERRORS, refuse_unmatched, series_writers
    from warmlink.orchestration.scenarios.replaced import with_replaced
    from warmlink.orchestration.scenarios.scenario import changed
    from warmlink.orchestration.system.replacement import Replacements

    given, wrong, kind = arguments.values_given(parameters, set_), mismatch or (), kind_named(fmus)
    how = {"step": step, "stop": stop, "master": master, "tolerance": tolerance}
    own = with_replaced(load_scenario(scenario, variant), Replacements.given(replace, map_))
    asked = None
    if report:
        from warmlink.orchestration.report.live.content import Asked

        options = {f"--{name}": told for name, told in {**how, "variant": variant}.items() if told}
        typed, files = arguments.values_given(None, set_), [str(each) for each in parameters or ()]
        asked = Asked(scenario, typed, wrong, options, files)
    written = arguments.listed(record) or ()
    if written:
        refuse_unmatched(written, [*_recorded(changed(own, controller, given, wrong), kind), *ERRORS])
    folder = out or Path("out") / own.name
    refuse_others(folder, "run")
    with locked_folder(folder), results_folder(folder, "run") as target:
        outcome = run_in_closed_loop(
            own, controller, parameters=given, mismatches=wrong, **how, fmus=kind, statistics=statistics
        )
        if outcome.time.size == 0:
            remark(f"{outcome.cut_short}; there are no results")
            raise SystemExit(FAILED)
        with interruption():  # a Ctrl-C now does not cost what was computed
            series = series_writers(outcome.table, written, csv)
            writers = _writers(outcome, series, asked)
            lost = write_files(target, writers, earlier=bool(results_in(folder, "run")))
    if json:
        answer_json(outcome.to_dict())
    else:
        answer(outcome.summary())
        if statistics:
            arguments.print_statistics(outcome.result.statistics)
        answer(f"report  {folder / 'report.html'}" if report else f"results  {folder}")
    # Where a further run ended early, which only tells of the error, the figures are those of a whole one.
    part = () if outcome.result.reason is None else ("the figures above describe that part only",)
    arguments.finish(folder, lost, outcome.cut_short, *part)


def _recorded(scenario: Scenario, kind: FmuKind | None) -> list[str]:
    """Names of the variables that a run of a scenario records."""
    from warmlink.orchestration.fmu_store import store
    from warmlink.orchestration.master.recording.recorder import is_recorded
    from warmlink.orchestration.simulation import variables

    system = scenario.system(scenario.files(store(kind, sorted(scenario.kinds), remark)))
    return [name for name, variable in variables(system).items() if is_recorded(variable)]


def _writers(
    outcome: ClosedLoop, series: Mapping[str, Callable[[Path], object]], asked: Asked | None
) -> dict[str, Callable[[Path], object]]:
    """What writes each file of the results, and a report of what was asked."""
    metrics = json_text.dumps(outcome.to_dict(), indent=2) + "\n"
    writers = {"metrics.json": lambda path: path.write_text(metrics, encoding="utf-8"), **series}
    if asked is not None:
        from warmlink.orchestration.report.closed_loop import write_report
        from warmlink.orchestration.report.live.page import kept_live_page

        page = kept_live_page(outcome.scenario, asked)
        if page:
            writers[LIVE_PAGE] = lambda path: path.write_text(page, encoding="utf-8")
        writers["report.html"] = lambda path: write_report(outcome, path, LIVE_PAGE if page else "")
    return writers
