"""`warmlink compare`: controllers x duty cycles x mismatches in one table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration import catalogue
from warmlink.orchestration.arm.library import NAME as ARM
from warmlink.orchestration.command_line.console import FAILED, answer, answer_json, progress_bar, remark
from warmlink.orchestration.commands.run import start_value_sets
from warmlink.orchestration.commands.study import interruptible, means, results
from warmlink.orchestration.own_law import load_own_law
from warmlink.orchestration.scenarios.load import load_scenario, names_on
from warmlink.orchestration.scenarios.scenario import NO_CONTROLLER, Scenario
from warmlink.orchestration.scenarios.setup import CELL
from warmlink.orchestration.studies import mismatch as mismatches_
from warmlink.orchestration.studies.compare import (
    Comparison,
    chosen_controllers,
    distinct,
    plan,
    run_comparison,
    write_csv,
)
from warmlink.orchestration.studies.given import assigned, told
from warmlink.orchestration.studies.mismatch import NOMINAL, Mismatch

DEFAULT_MISMATCHES = (
    NOMINAL,
    "thermal_high",
    "thermal_low",
    "insulated",
    "ventilated",
    "draw_1",
    "draw_2",
    "noisy_sensors",
    "camera_absent",
)
SYSTEMS = {CELL.name: DEFAULT_MISMATCHES, ARM: (NOMINAL,)}
"""Systems whose scenarios are compared unasked, each with the mismatches taken then."""


def compare_command(
    system: str,
    controllers: str | None,
    duty_cycles: str | None,
    mismatches: str | None,
    own: Sequence[str],
    parameter_files: list[Path],
    settings: list[str],
    fmus: str | None,
    out: Path | None,
    jobs: int,
    report: bool,
    as_json: bool,
) -> int:
    """Run, write and answer; gives the exit code."""
    sets = start_value_sets(parameter_files, settings)
    if system not in SYSTEMS:
        raise InputError(f"--system {system}: no such system to compare on; {instead(system, SYSTEMS)}")
    laws = chosen_controllers(_listed(controllers, _designed(system)))
    owned = [load_own_law(place) for place in own]
    distinct([*laws, *(law.name for law in owned)], "controllers")
    laws |= {law.name: law.component for law in owned}
    duties = _duties(_listed(duty_cycles, names_on(system)))
    for each in sets:
        sentence = told(each, laws)
        if sentence is not None:
            remark(sentence)
    wrong = _mismatches(_listed(mismatches, SYSTEMS[system]))
    cases = plan(laws, duties, wrong, assigned(sets, laws))
    folder = out or Path("out") / (f"compare_{system}" if system == ARM else "compare")
    kinds = {kind for duty in duties for kind in duty.setup.kinds(laws.values())}
    foreign = {name: path for duty in duties for name, path in duty.setup.foreign.items()}
    with interruptible(), means(kinds, foreign, owned, fmus, None, jobs, folder) as study:
        with progress_bar(f"{len(cases)} runs") as progress:
            comparison = run_comparison(cases, study.workers, progress)
        with results(folder) as target:
            write_csv(comparison, target / "compare.csv")
            if report:
                from warmlink.orchestration.report.comparison import write_report

                write_report(comparison, target / "report.html")
    if as_json:
        answer_json(_figures(comparison))
    else:
        from warmlink.orchestration.commands.compare_table import print_table

        print_table(comparison)
        answer(f"table   {folder / 'compare.csv'}")
        if report:
            answer(f"report  {folder / 'report.html'}")
    stopped = [row for row in comparison.rows.values() if row.outcome.stopped is not None]
    for row in stopped[:3]:
        remark(f"{row.controller}, {row.duty_cycle}, {row.mismatch}: stopped early: {row.outcome.stopped}")
    if len(stopped) > 3:
        remark(f"{len(stopped) - 3} more runs stopped early")
    return FAILED if stopped else 0


def _designed(system: str) -> list[str]:
    """Controllers to compare where none are named: all, or those that have a design for the system."""
    if system != ARM:
        return list(catalogue.controllers())
    from warmlink.orchestration.arm.setup import DESIGNED

    return list(DESIGNED)


def _listed(text: str | None, default: Sequence[str]) -> list[str]:
    found = listed(text)
    return list(default) if found is None else found


def listed(text: str | None) -> list[str] | None:
    """Names with commas between them, each once; None where none were asked for."""
    if text is None:
        return None
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def _duties(names: Sequence[str]) -> list[Scenario]:
    if not names:
        raise InputError(
            "--duty-cycles: names none; give some, as --duty-cycles windshield_wiper,stop_and_go"
        )
    duties = [load_scenario(name) for name in names]
    distinct([duty.name for duty in duties], "duty cycles")
    return duties


def _mismatches(names: Sequence[str]) -> list[Mismatch]:
    if not names:
        raise InputError("--mismatch: names none; give some, as --mismatch nominal,thermal_high")
    found = [mismatches_.load(name) for name in names]
    distinct([mismatch.name for mismatch in found], "mismatches")
    return found


def _figures(comparison: Comparison) -> list[dict[str, Any]]:
    return [
        {
            "controller": row.controller,
            "duty_cycle": row.duty_cycle,
            "mismatch": row.mismatch,
            **row.outcome.to_dict(),
            "removed_percent": row.removed_percent,
            "equal_within_um": row.equal_within_um,
            "productive_minutes_won": row.minutes_won if row.minutes_won == row.minutes_won else None,
            "equal_to_best": comparison.equal_to_best(row),
            "defeated": row.controller != NO_CONTROLLER and row.defeated,
        }
        for row in comparison.rows.values()
    ]
