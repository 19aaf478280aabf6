"""Controllers judged on measured logs, as `warmlink compare --data` asks for it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.orchestration.console import answer, answer_json, print_table, remark
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.results import results_folder

if TYPE_CHECKING:
    from warmlink.orchestration.scenarios.overrides import StartValueSet

HEADINGS = (
    "",
    "removed, median [%]",
    "rms, median [µm]",
    "worst after 2 min [µm]",
    "outside [%]",
    "ready [%]",
    "of it wrong [%]",
    "fine, not ready [%]",
    "travel [µm/h]",
)


def judge(
    logs: Sequence[Path],
    controllers: Sequence[str] | None,
    sets: Sequence[StartValueSet],
    learn: Sequence[Path],
    tolerance: str | float | None,
    columns: tuple[Sequence[str], Sequence[str], str],
    scenario: str | None,
    folder: Path,
    report: bool,
    json: bool,
) -> None:
    """Judge laws, write the table and the page, and answer; `columns` are units, names and decimal mark.

    The scenario, if one is given, says which machine the logs are of.
    """
    from warmlink.orchestration.diagnosis.data.columns import read_options
    from warmlink.orchestration.replay.compare import TOLERANCE, logged_on, replayed
    from warmlink.orchestration.scenarios.overrides import reached_controllers

    options = read_options(*columns)
    if scenario is not None:
        options, tolerance = logged_on(scenario, options, tolerance)
    with progress_bar(f"{len(logs)} logs") as progress, results_folder(folder, "compare") as target:
        found = replayed(
            *(logs, controllers, sets),
            learn=learn,
            tolerance=tolerance or TOLERANCE,
            options=options,
            progress=progress,
        )
        found.write_csv(target / "logs.csv")
        if report:
            from warmlink.orchestration.report.replay import write_replayed

            write_replayed(found, target / "report.html")
    for each in sets:
        from warmlink.orchestration.catalogue import controller_named

        laws = {name: controller_named(name).component for name in found.controllers}
        sentence = reached_controllers(each, laws)
        if sentence is not None:
            remark(sentence)
    if json:
        answer_json({"laws": {n: found.over_all(n) for n in found.controllers}, "runs": found.records()})
        return
    title = f"{len(logs)} measured log{'s' * (len(logs) > 1)}, tolerance ±{found.tolerance_um:g} µm"
    print_table(title, HEADINGS, found.table(), texts=1, width=200)
    answer(f"table   {folder / 'logs.csv'}")
    if report:
        answer(f"report  {folder / 'report.html'}")
