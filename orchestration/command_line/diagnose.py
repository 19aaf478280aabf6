"""`warmlink diagnose`: what a simulation gets wrong, why, and how much is gained by correcting it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import Json
from warmlink.orchestration.console import answer, answer_json, remark, spinner

NO_CONTROLLER = "none"


def diagnose(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Runs (CSV) of one warm-up cell, judged together; a run of the six-axis arm; or an "
            "experiment (TOML)."
        ),
    ],
    assume: Annotated[
        list[str] | None,
        typer.Option(
            help='Input that was not logged, as --assume torque=0, "ambient_temperature=22 degC" or '
            "pad_temperature=off. Repeatable."
        ),
    ] = None,
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help='Parameter that is known to differ, as --set "link.length=800 mm". Repeatable.',
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for results. Default: out/RUN, out/RUN+NEXT for two.")
    ] = None,
    json: Json = False,
) -> None:
    """Show what the simulation gets wrong, name the cause, extend the model, measure the improvement.

    Writes diagnosis.json, report.html and the extended model as .ssv and .ssp. The exit code is 0 whatever
    the verdict.
    """
    from warmlink.orchestration.arm.measured import is_arm_file

    folder = out or Path("out") / "+".join(path.stem for path in data)
    whole_arm = [path for path in data if is_arm_file(path)]
    if not whole_arm:
        _diagnose_cell(data, assume or [], set_ or [], folder, json)
    elif len(data) > 1:
        raise InputError(f"{whole_arm[0]}: a run of the whole arm stands alone; diagnose it by itself")
    elif assume or set_:
        raise InputError(
            f"{whole_arm[0]}: a run of the whole arm has every input and is compared with the shipped arm; "
            "leave --assume and --set out"
        )
    else:
        _diagnose_arm(data[0], folder, json)


def _diagnose_cell(
    paths: list[Path], assumed: list[str], settings: list[str], folder: Path, json: bool
) -> None:
    from warmlink.orchestration.catalogue import controller
    from warmlink.orchestration.command_line.options import settings_given
    from warmlink.orchestration.diagnosis.answer.entries import json_content
    from warmlink.orchestration.diagnosis.answer.words import summary
    from warmlink.orchestration.diagnosis.diagnose import diagnose as find
    from warmlink.orchestration.fmu_store import store
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSP, SSV, write_diagnosis
    from warmlink.orchestration.system.shipped import SHIPPED

    with spinner(f"Diagnosing {', '.join(path.name for path in paths)}") as progress:
        found = find(*paths, assumed=assumed, settings=settings_given(settings), progress=progress)
    for each in found.experiment.remarks:
        remark(each)
    _give(json_content(found, SSV, SSP) if json else summary(found))
    with _told_what_is_lost(folder):
        blueprint = SHIPPED[found.experiment.rig.name]
        needed = blueprint.components_with(controller(NO_CONTROLLER).name).values()
        write_diagnosis(found, folder, store(None, sorted(needed), remark))
    if not json:
        files = f"figures  {folder / JSON}    extended model  {folder / SSP}"
        answer(f"report  {folder / PAGE}    {files}")


def _diagnose_arm(path: Path, folder: Path, json: bool) -> None:
    from warmlink.orchestration.arm.diagnose import diagnose_arm
    from warmlink.orchestration.arm.measured import arm_experiments
    from warmlink.orchestration.report.diagnosis import JSON, PAGE

    with spinner(f"Diagnosing {path.name}") as progress:
        found = diagnose_arm(arm_experiments(path), progress=progress)
    _give(found.to_json() if json else found.summary())
    with _told_what_is_lost(folder):
        found.write(folder)
    if not json:
        answer(f"figures  {folder / JSON}    reports  {folder / 'axis1' / PAGE} and so on")


def _give(found: str | dict[str, Any]) -> None:
    """Print a summary, or figures for other programs."""
    if isinstance(found, str):
        answer(found)
    else:
        answer_json(found)


@contextmanager
def _told_what_is_lost(folder: Path) -> Iterator[None]:
    """Turn a failure to write into a sentence: what was found was printed before it."""
    try:
        yield
    except (OSError, InputError) as fault:
        told = str(fault)
        if not isinstance(fault, InputError):
            told = (
                f"{folder}: cannot be written ({fault.strerror or fault}); make room or choose another --out"
            )
        raise InputError(
            f"{told}; the answer above is all there is, its report and extended model are lost: run it again"
        ) from None
