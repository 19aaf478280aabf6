"""`warmlink compare --system SixAxisArm`: controllers x programs x mismatches of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.arm.compare import ArmRow, compare_arm, write_csv
from warmlink.orchestration.arm.compensation import DESIGNED
from warmlink.orchestration.arm.library import NAME, arm_scenario_names
from warmlink.orchestration.arm.run import arm_kinds
from warmlink.orchestration.arm.scenario import load_arm_scenario
from warmlink.orchestration.command_line.console import answer, answer_json, progress_bar, remark
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.fmu_store import FmuKind, store
from warmlink.orchestration.studies import mismatch
from warmlink.orchestration.studies.mismatch import NOMINAL


def compare_arm_command(
    controllers: Sequence[str] | None,
    programs: Sequence[str] | None,
    mismatches: Sequence[str] | None,
    fmus: FmuKind | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run, write and answer."""
    laws = list(DESIGNED if controllers is None else controllers)
    scenarios = [load_arm_scenario(name) for name in (programs or arm_scenario_names())]
    found = [mismatch.load(name) for name in (mismatches or [NOMINAL])]
    if not laws:
        raise InputError("--controllers: names none; give some, as --controllers lag,observer")
    for law in laws:
        if law not in DESIGNED:
            raise InputError(f"{law}: has no design for the arm's axes; {instead(law, DESIGNED)}")
    kinds = {kind for law in laws for kind in arm_kinds(law)}
    chosen = store(fmus, sorted(kinds), remark)
    folder = out or Path("out") / f"compare_{NAME}"
    with fresh_folder(folder) as target:
        with progress_bar(f"{len(scenarios)} programs") as progress:
            rows = compare_arm(laws, scenarios, found, chosen, progress)
        write_csv(rows, target / "compare.csv")
    if as_json:
        answer_json([asdict(row) for row in rows])
        return
    _print(rows)
    answer(f"table   {folder / 'compare.csv'}")


def _print(rows: Sequence[ArmRow]) -> None:
    """Print the largest tool-point errors: a line a program and mismatch, a column a controller."""
    from rich.console import Console
    from rich.table import Table

    laws = list(dict.fromkeys(row.controller for row in rows))
    by_run = {(row.duty_cycle, row.mismatch, row.controller): row for row in rows}
    table = Table(title="largest tool-point error [µm], share removed", title_justify="left", box=None)
    table.add_column("program")
    table.add_column("mismatch")
    for law in laws:
        table.add_column(law, justify="right")
    for program, wrong in dict.fromkeys((row.duty_cycle, row.mismatch) for row in rows):
        cells = [_cell(by_run[program, wrong, law]) for law in laws]
        table.add_row(program, wrong, *cells)
    Console().print(table)


def _cell(row: ArmRow) -> str:
    share = "" if not row.removed_percent else f" ({row.removed_percent:.0f} %)"
    return f"{row.max_abs_um:.1f}{share}"
