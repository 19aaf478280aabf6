"""`warmlink diagnose`: what a simulation gets wrong, why, and how much a correction improves it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import settings_given
from warmlink.orchestration.console import answer, answer_json, print_table, remark, spinner

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.data.experiment import Experiment


def diagnose(
    data: list[Path],
    *,
    assume: list[str] | None = None,
    set_: list[str] | None = None,
    scenario: str | None = None,
    noise: list[str] | None = None,
    unit: list[str] | None = None,
    map_: list[str] | None = None,
    decimal: str = "",
    replace: list[str] | None = None,
    calibrate_only: bool = False,
    check: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> None:
    """Compare measurements with the simulation, name the cause of the difference, and extend the model.

    Writes diagnosis.json, report.html, and the extended model as .ssv and .ssp. If the data cannot tell
    several causes apart, it also writes next_experiment.toml and .csv: carry out this duty cycle, then
    diagnose both runs together. The exit code is 0 whatever the verdict.

    Parameters
    ----------
    data : One or more measured runs of the same warm-up cell, as a logger or a spreadsheet writes them (CSV,
        text, Parquet, Excel); a run of the six-axis arm; or an experiment file (TOML).
    assume : Constant value of an input that was not logged, for example --assume torque=0,
        "ambient_temperature=22 degC" or pad_temperature=off. Repeatable.
    set_ : Parameter of your cell that differs from the nominal one, for example --set "link.length=800 mm".
        Repeatable.
    scenario : Scenario file (TOML) whose [parameters] describe your cell; --set changes them further.
    noise : Standard deviation of the noise of a column, for example --noise "tip_temperature=0.1 K".
        Repeatable.
    unit : Unit that is missing from a header: --unit "T_base=degC" for one column, --unit degC for all
        columns of that quantity, --unit "time=%d/%m/%Y %H:%M:%S" for dates. Repeatable.
    map_ : Which variable a column holds, for example --map "T_base=base_temperature"; --map "T9=" ignores the
        column; --map link.heat_flow=Q what a replaced link calls its variable. Repeatable.
    decimal : Decimal mark, `comma` or `point`, if the file could be read either way.
    calibrate_only : Fit what the experiment calibrates, and look for no causes.
    check : Show how the files are understood, without a diagnosis.
    out : Folder for results. Default: out/RUN, or out/RUN+NEXT for two runs.
    """
    from warmlink.orchestration.diagnosis.arm.measured import arm_experiments, is_arm_file
    from warmlink.orchestration.diagnosis.data.columns import said
    from warmlink.orchestration.diagnosis.data.experiment import calibrating
    from warmlink.orchestration.diagnosis.data.inputs import parameters_of, with_noise
    from warmlink.orchestration.diagnosis.diagnose import read
    from warmlink.orchestration.system.replacement import Replacements

    folder = out or Path("out") / "+".join(path.stem for path in data)
    whole_arm = [path for path in data if is_arm_file(path)]
    if whole_arm and not check and len(data) > 1:
        raise InputError(
            f"{whole_arm[0]}: a run of the whole arm cannot be combined with others; diagnose it by itself"
        )
    if (
        whole_arm
        and not check
        and any((assume, set_, scenario, noise, unit, map_, decimal, calibrate_only, replace))
    ):
        raise InputError(
            f"{whole_arm[0]}: a run of the whole arm has every input and is compared with the shipped arm; "
            "leave out all options but --out, --check and --json"
        )

    def measured() -> Experiment:
        """The measurements, with the options that describe them."""
        given = {**(parameters_of(scenario) if scenario else {}), **settings_given(set_)}
        parts = tuple(f"{each.partition('=')[0].strip()}." for each in replace or ())
        own = [name for name in map_ or () if parts and name.startswith(parts)]
        columns = [name for name in map_ or () if name not in own]
        told = said(unit or [], columns, decimal, Replacements.given(replace, own))
        experiment = with_noise(read(data, assume or [], given, told), settings_given(noise, "--noise"))
        return calibrating(experiment) if calibrate_only else experiment

    if check:
        _show(list(arm_experiments(data[0]).values()) if whole_arm else [measured()], bool(whole_arm), json)
    elif whole_arm:
        _diagnose_arm(data[0], folder, json)
    else:
        _diagnose_cell(data, measured, folder, json)


def _show(experiments: list[Experiment], whole_arm: bool, json: bool) -> None:
    """Print how the files are understood."""
    found = [experiment.understood() for experiment in experiments]
    if json:
        answer_json(found if whole_arm else found[0])
        return
    headings = ("column", "is", "unit", "cells", "least", "largest")
    for each in found:
        for run in each["runs"]:
            answer(_in_words(run))
            rows = [
                (
                    column["column"],
                    column["variable"],
                    f"{column['unit']} ({column['unit_from']})",
                    f"{column['filled']} of {column['cells']}",
                    *("" if column[end] is None else f"{column[end]:.5g}" for end in ("least", "largest")),
                )
                for column in run["columns"]
            ]
            print_table("", headings, rows, texts=3, width=120)
        for text in each["remarks"]:
            answer(f"- {text}")


def _in_words(run: dict[str, Any]) -> str:
    """How a run is understood, in two lines, its columns aside."""
    gaps, pauses = run["gaps"], "no gaps"
    if gaps:
        longest = max(gaps, key=lambda gap: gap["lasts_s"])
        pauses = f"{len(gaps)} gaps, the longest {longest['lasts_s']:g} s from {longest['at_s']:g} s on"
    over = f"{run['duration_s'] / 60:.4g} min, one every {run['spacing_s']:g} s, {pauses}"
    held_out = ", held out" if run["held_out"] else ""
    return f"{run['name']}: {run['form']}\n{run['rows']} rows over {over}{held_out}"


def _diagnose_cell(paths: list[Path], measured: Callable[[], Experiment], folder: Path, json: bool) -> None:
    from warmlink.orchestration.catalogue import controller
    from warmlink.orchestration.diagnosis.answer.entries import json_content
    from warmlink.orchestration.diagnosis.answer.words import summary
    from warmlink.orchestration.diagnosis.diagnose import SCENARIO, diagnose_experiment
    from warmlink.orchestration.fmu_store import store
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSP, SSV, write_diagnosis

    with spinner(f"Diagnosing {', '.join(path.name for path in paths)}") as progress:
        progress("reading")
        found = diagnose_experiment(measured(), progress)
    for each in found.experiment.remarks:
        remark(each)
    if json:
        answer_json(json_content(found, SSV, SSP))
    else:
        answer(summary(found))
    with _lost_files_named(folder):
        rig, none = found.experiment.rig, controller("none").name
        needed = set() if rig.own else set(rig.blueprint.components_with(none).values())
        files = write_diagnosis(found, folder, store(None, sorted(needed), remark))
    if not json:
        answer(f"report  {folder / PAGE}    figures  {folder / JSON}    extended model  {folder / SSP}")
        if SCENARIO in files:
            answer(f"next    {files[SCENARIO]}    practise it: warmlink hide EFFECT --duty {files[SCENARIO]}")


def _diagnose_arm(path: Path, folder: Path, json: bool) -> None:
    from warmlink.orchestration.diagnosis.arm.diagnose import diagnose_arm
    from warmlink.orchestration.diagnosis.arm.measured import arm_experiments
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSV, write_diagnoses

    with spinner(f"Diagnosing {path.name}") as progress:
        found = diagnose_arm(arm_experiments(path), progress=progress)
    whole = found.to_json(SSV)
    if json:
        answer_json(whole)
    else:
        answer(found.summary())
    with _lost_files_named(folder):
        write_diagnoses(found.by_name, whole, folder)
    if not json:
        answer(f"figures  {folder / JSON}    reports  {folder / 'axis1' / PAGE} and so on")


@contextmanager
def _lost_files_named(folder: Path) -> Iterator[None]:
    """Turn a failure to write into an InputError that says what is lost; the summary was printed before."""
    try:
        yield
    except (OSError, InputError) as fault:
        sentence = str(fault)
        if isinstance(fault, OSError):
            reason = fault.strerror or fault
            sentence = f"{folder}: cannot be written ({reason}); make room or choose another --out"
        raise InputError(
            f"{sentence}; only the answer above is left, report and extended model are lost: run it again"
        ) from None
