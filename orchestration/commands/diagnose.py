"""`warmlink diagnose` and `warmlink hide`: what a simulation gets wrong, and runs to practise on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError, NoRoomError
from warmlink.fmus.names import instead
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.commands.console import answer, answer_json, remark, spinner

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.practice.hide import Noise, Vector

NO_CONTROLLER = "none"


def diagnose_command(
    paths: Sequence[Path], assumed: Sequence[str], settings: list[str], out: Path | None, as_json: bool
) -> None:
    """Diagnose, write the files and print the summary."""
    from warmlink.orchestration.arm.measured import is_arm_file
    from warmlink.orchestration.commands.run import settings_given

    folder = out or Path("out") / "+".join(path.stem for path in paths)
    for path in paths:
        if is_arm_file(path):
            if len(paths) > 1:
                raise InputError(f"{path}: a run of the whole arm stands alone; diagnose it by itself")
            if assumed or settings:
                raise InputError(
                    f"{path}: a run of the whole arm has every input, and is compared with the shipped arm; "
                    "leave --assume and --set out"
                )
            _diagnose_arm(path, folder, as_json)
            return
    from warmlink.orchestration.diagnosis.answer.entries import json_content
    from warmlink.orchestration.diagnosis.answer.words import summary
    from warmlink.orchestration.diagnosis.diagnose import diagnose
    from warmlink.orchestration.fmu_store import store
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSP, SSV, write_diagnosis
    from warmlink.orchestration.system.shipped import SHIPPED

    with spinner(f"Diagnosing {', '.join(path.name for path in paths)}") as progress:
        diagnosis = diagnose(*paths, assumed=assumed, settings=settings_given(settings), progress=progress)
    for each in diagnosis.experiment.remarks:
        remark(each)
    if as_json:
        answer_json(json_content(diagnosis, SSV, SSP))
    else:
        answer(summary(diagnosis))
    with _told_what_is_lost(folder):
        blueprint = SHIPPED[diagnosis.experiment.rig.name]
        needed = blueprint.components_with(controller(NO_CONTROLLER).name).values()
        write_diagnosis(diagnosis, folder, store(None, sorted(needed), remark))
    if not as_json:
        files = f"figures  {folder / JSON}    extended model  {folder / SSP}"
        answer(f"report  {folder / PAGE}    {files}")


_LOST = (
    "the answer above is all there is, its report and extended model are lost: run it again, or choose "
    "another --out"
)


@contextmanager
def _told_what_is_lost(folder: Path) -> Iterator[None]:
    """Turn a failure to write into a sentence: what was found was printed before it."""
    try:
        yield
    except NoRoomError as fault:
        raise NoRoomError(f"{fault}; {_LOST}") from None
    except OSError as fault:
        raise InputError(f"{folder}: cannot be written ({fault.strerror or fault}); {_LOST}") from None


def _diagnose_arm(path: Path, folder: Path, as_json: bool) -> None:
    from warmlink.orchestration.arm.diagnose import diagnose_arm
    from warmlink.orchestration.arm.measured import arm_experiments
    from warmlink.orchestration.report.diagnosis import JSON, PAGE

    with spinner(f"Diagnosing {path.name}") as progress:
        diagnosis = diagnose_arm(arm_experiments(path), progress=progress)
    if as_json:
        answer_json(diagnosis.to_json())
    else:
        answer(diagnosis.summary())
    with _told_what_is_lost(folder):
        diagnosis.write(folder)
    if not as_json:
        answer(f"figures  {folder / JSON}    reports  {folder / 'axis1' / PAGE} and so on")


GRID, FEA = "grid", "fea"
"""Solvers behind a made-up run: a rod on a grid, 3-D finite elements."""


def hide_command(
    effects: Sequence[str],
    duty: str | None,
    out: Path,
    seed: int,
    noise: str,
    solver: str,
    axis: int | None,
) -> None:
    """Write a run that hides effects."""
    from warmlink.orchestration.diagnosis.practice.effects import EFFECTS, effect_of
    from warmlink.orchestration.diagnosis.practice.hide import (
        INFORMATIVE,
        REAL,
        WHITE,
        duty_of,
        hide,
        write_csv,
    )
    from warmlink.orchestration.scenarios.duty import length

    if solver not in (GRID, FEA):
        raise InputError(f"--with {solver}: no such solver; {instead(solver, (GRID, FEA))}")
    kinds = {"white": WHITE, "real": REAL}
    if noise not in kinds:
        raise InputError(f"--noise {noise}: no such noise; {instead(noise, kinds)}")
    if out.suffix != ".csv":
        raise InputError(f"--out {out}: not a CSV file; give a name that ends in .csv")
    strengths = {}
    for given in effects:
        name, equals, size = given.partition("=")
        effect = effect_of(name)
        try:
            strengths[name] = float(size) if equals else effect.size
        except ValueError:
            strengths[name] = math.nan
        if not math.isfinite(strengths[name]):
            raise InputError(f"{given}: {size!r} is not a number; give the strength in SI units")
    hidden = ", ".join(f"{name} = {size:g}" for name, size in strengths.items()) or "nothing"
    if axis is not None:
        if solver != GRID:
            raise InputError(f"--axis {axis}: the arm is computed by its FMUs; leave --with {solver} out")
        if duty is not None:
            raise InputError(f"--axis {axis}: the arm follows a program of its own; leave --duty {duty} out")
        columns = _hidden_in_arm(strengths, axis, kinds[noise], seed)
        write_csv(columns, out)
        answer(f"{out}: the six-axis arm with {hidden} hidden in axis {axis} (SI units, seed {seed})")
        return
    segments = INFORMATIVE if duty is None else duty_of(duty)
    if solver == FEA:
        from warmlink.orchestration.diagnosis.practice.hidden_fea import hide_with_fea

        columns = hide_with_fea(strengths, segments, noise=kinds[noise], seed=seed)
    else:
        columns = hide(strengths, segments, noise=kinds[noise], seed=seed)
    write_csv(columns, out)
    hours = length(segments) / 3600
    answer(
        f"{out}: {hours:.3g} h with {hidden} hidden (SI units, seed {seed}); of {len(EFFECTS)} effects known"
    )


def _hidden_in_arm(effects: dict[str, float], axis: int, noise: Noise, seed: int) -> dict[str, Vector]:
    from warmlink.orchestration.arm.hide import hide_in_arm
    from warmlink.orchestration.arm.run import arm_kinds
    from warmlink.orchestration.fmu_store import store

    return hide_in_arm(effects, axis, store(None, arm_kinds(None), remark), noise=noise, seed=seed)
