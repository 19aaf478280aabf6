"""`warmlink compare`, the table that it prints, and what its marks mean."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line import arguments
from warmlink.orchestration.command_line.studies import interruptible, kept_results, run_options
from warmlink.orchestration.console import FAILED, answer, answer_json, print_table, remark
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.results import refuse_others

if TYPE_CHECKING:
    from rich.text import Text

    from warmlink.orchestration.studies.compare import Comparison, Row

COMMANDS = ("compare",)

WIDE = 240
"""Width in characters of the table where the output is not a terminal."""

BEST, BEYOND, HARM = "*", "!", "!!"
LEGEND = (
    f"{BEST} best in its row, or equal to it within the error budget   {BEYOND} beyond tolerance   "
    f"{HARM} worse than no compensation"
)


def _parts(comparison: Comparison) -> dict[str, list[str]]:
    """Mismatches of each part of the table, by its heading: the nominal one, and the worst of the others."""
    from warmlink.orchestration.scenarios.mismatch import NOMINAL

    others = [name for name in comparison.mismatches if name != NOMINAL]
    parts = {NOMINAL: [NOMINAL]} if NOMINAL in comparison.mismatches else {}
    if others:
        parts[others[0] if len(others) == 1 else f"worst of {len(others)} mismatches"] = others
    return parts


def legend(comparison: Comparison) -> str:
    """What the marks of the table mean, and the numbers by which a figure says which mismatch it is of."""
    lines = [LEGEND]
    for mismatches in _parts(comparison).values():
        if len(mismatches) > 1:
            which = "  ".join(f"({i}) {name}" for i, name in enumerate(mismatches, start=1))
            lines.append(
                f"{which}: mismatch of the figure; a share is of no compensation under the same mismatch"
            )
    return "\n".join(lines)


def table(comparison: Comparison) -> list[tuple[str | Text, ...]]:
    """Rows of the table: a duty cycle each, with the cells of all controllers."""
    from rich.text import Text

    parts = _parts(comparison)
    first = next(iter(parts.values()))[0]
    rows: list[tuple[str | Text, ...]] = []
    for heading, mismatches in parts.items():
        rows.append((Text(heading, "bold"),))
        which = {name: f" ({i})" for i, name in enumerate(mismatches, start=1)}
        which = which if len(mismatches) > 1 else dict.fromkeys(mismatches, "")
        for duty in comparison.duty_cycles:
            held = [comparison.worst(name, [duty], mismatches) for name in comparison.controllers]
            best = min((row.outcome.max_abs_um for row in held if row.outcome.stopped is None), default=0.0)
            rows.append((f"  {duty}", *(_cell(row, best, which[row.mismatch]) for row in held)))
    won = [
        sum(comparison.row(name, duty, first).minutes_won for duty in comparison.duty_cycles)
        for name in comparison.controllers
    ]
    title = ("productive minutes won compared with warming up first", "bold"), f" ({first}, all rows)"
    return [
        *rows,
        (Text.assemble(*title), *(f"{each:+.0f}{'   ' if i else ''}" for i, each in enumerate(won))),
    ]


def _cell(row: Row, best_um: float, which: str) -> str:
    """Figures of one run with their marks; `best_um` is the smallest largest error of its row.

    `which` says of which mismatch they are, where the row is of several.
    """
    from warmlink.orchestration.closed_loop.metrics import shown_percent
    from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER

    if row.outcome.stopped is not None:
        return f"stopped{which} {HARM:<3}"
    error = f"{row.outcome.max_abs_um:.1f}{which}"
    if row.controller == NO_CONTROLLER:
        return error
    removed = "" if row.removed_percent is None else shown_percent(row.removed_percent)
    mark = HARM if row.worse_than_none else BEYOND if row.beyond_tolerance else ""
    return f"{error} {removed:>5} {mark + (BEST if row.equals(best_um) else ''):<3}"


def compare(
    logs: list[Path] | None = None,
    *,
    data: list[Path] | None = None,
    learn: list[Path] | None = None,
    tolerance: str | None = None,
    unit: list[str] | None = None,
    decimal: str = "",
    controllers: str | None = None,
    duty_cycles: str | None = None,
    mismatch: str | None = None,
    with_: list[str] | None = None,
    parameters: list[Path] | None = None,
    set_: list[str] | None = None,
    fmus: str | None = None,
    system: str = DEFAULT,
    scenario: Path | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    out: Path | None = None,
    scheduler: str | None = None,
    jobs: int = 2,
    exact: bool = False,
    report: bool = True,
    json: bool = False,
) -> None:
    """Compare controllers with each other and with no compensation, over duty cycles and mismatches.

    A --set of a compensator's parameter reaches every controller that has this parameter; mismatches are
    applied after all other changes. Writes compare.csv and report.html. After an interruption the same
    command continues. Differences within the error budget count as equal. The table marks where an error is
    beyond the tolerance, and where a controller is worse than none.

    With --scenario, a cell of one's own is compared in: its parameters and sensors hold in every duty cycle,
    and without --duty-cycles it is compared in its own.

    With --data no plant is needed: controllers are run over measured logs. Each sees what was logged, and its
    error is the measured growth minus its correction; one with a camera sees the growth whenever it was
    measured. A column `growth`, which nobody sees, is judged by if there is one. Logs of a machine of your
    own are read by the roles in its --scenario.

    Example: `warmlink compare --controllers lag,observer --duty-cycles stop_and_go --mismatch nominal`

    Parameters
    ----------
    logs : With --data: further logs.
    data : Measured logs of one machine to judge on, with columns as `warmlink diagnose` reads them.
        Repeatable.
    learn : With --data: logs from which controllers learn first that can. Repeatable.
    tolerance : With --data: error that production allows. Default: that of the --scenario, or 5 um.
    unit : With --data: unit that is missing from a header, as --unit "T_base=degC". Repeatable.
    decimal : With --data: decimal mark, `comma` or `point`, if a log could be read either way.
    controllers : Controllers, such as `lag,observer`. Default: all (`warmlink list`).
    duty_cycles : Names of duty cycles, or TOML or CSV files of your own, separated by commas. Default: all,
        or that of the --scenario.
    mismatch : How the real cell differs from the one that the controllers were designed for: `nominal`,
        `thermal_high`, `thermal_low`, `insulated`, `ventilated`, `losses_high`, `losses_low`,
        `noisy_sensors`, `camera_absent`, `draw_1`, `draw_2` and so on (the number is the seed), or TOML
        files, separated by commas. Default: nine of them.
    with_ : A controller of your own, as `my_law.py:MyLaw`. Repeatable.
    system : `WarmupCell`, or `SixAxisArm`, for which a duty cycle is a program.
    scenario : A scenario (TOML) of a cell of your own: its parameters and sensors hold, and its duty cycle.
        With --data: a scenario of any machine, whose roles say which variables the columns are.
    out : Folder for results. Default: out/compare.
    """
    from warmlink.orchestration.scenarios.overrides import reached_controllers
    from warmlink.orchestration.scenarios.replaced import with_replaced
    from warmlink.orchestration.studies.compare import compared, plan_on, write_csv
    from warmlink.orchestration.system.replacement import Replacements

    sets = arguments.sets_given(parameters, set_)
    if data:
        from warmlink.orchestration.command_line.logs import judge

        others = duty_cycles, mismatch, replace, fmus, scheduler
        if any(each is not None for each in others) or exact or system != DEFAULT:
            raise InputError(
                "--data: measured logs are compared as they are; leave out all options but --controllers, "
                "--with, --set, --parameters, --learn, --scenario, --tolerance, --unit, --map, --decimal, "
                "--out"
            )
        named = None if controllers is None and not with_ else [*(arguments.listed(controllers) or ())]
        judge(
            [*data, *(logs or ())],
            None if named is None else [*named, *(with_ or ())],
            sets,
            learn or [],
            tolerance,
            (unit or [], map_ or [], decimal),
            None if scenario is None else str(scenario),
            out or Path("out") / "compare",
            report,
            json,
        )
        return
    if logs or learn or unit or decimal or tolerance:
        raise InputError(
            "compare: further logs, --learn, --tolerance, --unit and --decimal are for measured logs; "
            "give them with --data LOG"
        )
    laws, duties, wrong = (arguments.listed(each) for each in (controllers, duty_cycles, mismatch))
    plan = plan_on(system, laws, duties, wrong, sets, scenario, with_ or ())
    given = Replacements.given(replace, map_)
    plan = plan._replace(scenarios=tuple(with_replaced(each, given) for each in plan.scenarios))
    for each in sets:
        sentence = reached_controllers(each, plan.laws)
        if sentence is not None:
            remark(sentence)
    for first in {each.controller.name: each for each in plan.scenarios}.values():
        arguments.advise(first)
    folder = out or Path("out") / ("compare" if system == DEFAULT else f"compare_{system}")
    refuse_others(folder, "compare")
    options = run_options(fmus, jobs, scheduler, exact)
    with (
        interruptible(),
        compared(plan, options, folder) as comparison,
        kept_results(folder, "compare") as target,
    ):
        write_csv(comparison, target / "compare.csv")
        if report:
            from warmlink.orchestration.report.comparison import write_comparison

            write_comparison(comparison, target / "report.html")
    _answer(comparison, folder, report, json)


def _answer(comparison: Comparison, folder: Path, report: bool, json: bool) -> None:
    """Print the table and what its marks mean, or the rows as JSON; exit code 1 if a run stopped early."""
    if json:
        answer_json(comparison.records())
    else:
        title = "largest error in µm, and the share of it removed"
        print_table(title, ("", *comparison.controllers), table(comparison), texts=1, width=WIDE)
        answer(f"{legend(comparison)}\ntable   {folder / 'compare.csv'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    stopped = [row for row in comparison.rows.values() if row.outcome.stopped is not None]
    for row in stopped[:3]:
        remark(f"{row.controller}, {row.duty_cycle}, {row.mismatch}: stopped early: {row.outcome.stopped}")
    if len(stopped) > 3:
        remark(f"{len(stopped) - 3} more runs stopped early")
    if stopped:
        raise SystemExit(FAILED)
