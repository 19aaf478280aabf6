"""What `--data LOG` asks for: a law learnt from logs (`design`), and laws judged on them (`compare`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.orchestration.console import answer, answer_json, print_table, remark
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import progress_bar, spinner
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


def learn(
    logs: Sequence[Path],
    law: str,
    sensors: Sequence[str] | None,
    stds: tuple[str | None, str | None],
    sample_time: str,
    scenario: str | None,
    settings: Mapping[str, str],
    units: Sequence[str],
    names: Sequence[str],
    decimal: str,
    path: Path,
    report: Path | None,
    json: bool,
) -> None:
    """Learn a law, write its parameters and page, and answer; `stds` of a thermometer and the camera."""
    from warmlink.orchestration.diagnosis.data.options import read_options
    from warmlink.orchestration.machine import DEFAULT
    from warmlink.orchestration.replay.learn import LearntLaw
    from warmlink.orchestration.studies.design import design

    with spinner("Learning") as progress:
        progress("reading")
        found = design(
            scenario or DEFAULT,
            law,
            sensors,
            sensor_std=stds[0],
            camera_std=stds[1],
            sample_time=sample_time,
            parameters=settings,
            data=[*logs],
            options=read_options(units, names, decimal),
        )
        assert isinstance(found, LearntLaw)
        told = found.summary()
        if report is not None:
            from warmlink.orchestration.report.learning import write_learnt

            with fresh_file(report) as target:
                write_learnt(found, target)
        found.write(path)
    if json:
        answer_json({**found.to_dict(), "values": str(path)})
    else:
        answer(told)
        answer(f"values  {path}")
        if report is not None:
            answer(f"report  {report}")


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
    from warmlink.orchestration.diagnosis.data.options import read_options
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

        named = map(controller_named, controllers or found.controllers)
        laws = {law.name: law.component for law in named}
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
