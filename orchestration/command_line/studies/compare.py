"""`warmlink compare`: run every controller in every duty cycle and mismatch, and print one table."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line import options
from warmlink.orchestration.command_line.options import (
    Exact,
    Fmus,
    Jobs,
    Json,
    Parameters,
    Report,
    ScenarioFile,
    Scheduler,
    Set,
)
from warmlink.orchestration.console import FAILED, answer, answer_json, progress_bar, remark


def compare(
    controllers: Annotated[
        str | None, typer.Option(help="Controllers, such as `lag,observer`. Default: all (`warmlink list`).")
    ] = None,
    duty_cycles: Annotated[
        str | None,
        typer.Option(
            help="Names of duty cycles, or TOML or CSV files of your own, separated by commas. Default: all."
        ),
    ] = None,
    mismatch: Annotated[
        str | None,
        typer.Option(
            help="How the real cell differs from the one that the controllers were designed for: `nominal`, "
            "`thermal_high`, `thermal_low`, `insulated`, `ventilated`, `losses_high`, `losses_low`, "
            "`noisy_sensors`, `camera_absent`, `draw_1`, `draw_2` and so on (the number is the seed), or "
            "TOML files, separated by commas. Default: nine of them."
        ),
    ] = None,
    with_: Annotated[
        list[str] | None,
        typer.Option("--with", help="A controller of your own, as `my_law.py:MyLaw`. Repeatable."),
    ] = None,
    parameters: Parameters = None,
    set_: Set = None,
    fmus: Fmus = None,
    system: Annotated[
        str, typer.Option(help="`WarmupCell`, or `SixAxisArm`, for which a duty cycle is a program.")
    ] = "WarmupCell",
    scenario: ScenarioFile = None,
    replace: options.Replace = None,
    map_: options.Rename = None,
    out: Annotated[Path | None, typer.Option(help="Folder for results. Default: out/compare.")] = None,
    scheduler: Scheduler = None,
    jobs: Jobs = 2,
    exact: Exact = False,
    report: Report = True,
    json: Json = False,
) -> None:
    """Compare controllers with each other and with no compensation, over duty cycles and mismatches.

    A --set of a compensator's parameter reaches every controller that has this parameter; mismatches are
    applied after all other changes. Writes compare.csv and report.html. After an interruption the same
    command continues. Differences within the error budget count as equal. The table marks where an error is
    beyond the tolerance, and where a controller is worse than none.

    With --scenario, a cell of one's own is compared in: its parameters and sensors hold in every duty cycle.

    Example: `warmlink compare --controllers lag,observer --duty-cycles stop_and_go --mismatch nominal`
    """
    from warmlink.orchestration.closed_loop.belief import judged
    from warmlink.orchestration.command_line.studies.compare_table import print_table
    from warmlink.orchestration.command_line.studies.in_order import interruptible, results
    from warmlink.orchestration.fmu_store import kind_named
    from warmlink.orchestration.scenarios.own_system import with_replaced
    from warmlink.orchestration.studies.at_work import Means, at_work
    from warmlink.orchestration.studies.compare import run_comparison, write_csv
    from warmlink.orchestration.studies.plan import SYSTEMS, designed_for, plan_on, reached_controllers
    from warmlink.orchestration.system.replacement import Replacements

    sets = options.sets_given(parameters, set_)
    laws = options.listed(controllers)
    if with_ and system in SYSTEMS:
        laws = [*(designed_for(system) if laws is None else laws), *with_]
    plan = plan_on(system, laws, options.listed(duty_cycles), options.listed(mismatch), sets, scenario)
    given = Replacements.given(replace, map_)
    plan = dataclasses.replace(plan, scenarios=tuple(with_replaced(each, given) for each in plan.scenarios))
    for each in sets:
        sentence = reached_controllers(each, plan.laws)
        if sentence is not None:
            remark(sentence)
    for first in {each.controller.name: each for each in plan.scenarios}.values():
        advice, _ = judged(first)
        if advice is not None:
            remark(advice)
    cases = plan.cases
    folder = out or Path("out") / ("compare" if system == "WarmupCell" else f"compare_{system}")
    means = Means(kind_named(fmus), jobs, scheduler, exact)
    with interruptible(), at_work(plan.scenarios, means, folder) as work:
        with progress_bar(f"{len(cases)} runs") as progress:
            comparison = run_comparison(cases, work.workers, progress)
        with results(folder) as target:
            write_csv(comparison, target / "compare.csv")
            if report:
                from warmlink.orchestration.report.comparison import write_report

                write_report(comparison, target / "report.html")
    if json:
        answer_json(comparison.records())
    else:
        print_table(comparison)
        answer(f"table   {folder / 'compare.csv'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    stopped = [row for row in comparison.rows.values() if row.outcome.stopped is not None]
    for row in stopped[:3]:
        remark(f"{row.controller}, {row.duty_cycle}, {row.mismatch}: stopped early: {row.outcome.stopped}")
    if len(stopped) > 3:
        remark(f"{len(stopped) - 3} more runs stopped early")
    if stopped:
        raise SystemExit(FAILED)
