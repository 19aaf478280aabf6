"""`warmlink diagnose`: what a simulation gets wrong, and why; `warmlink hide`: runs to practise it on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import settings_given
from warmlink.orchestration.console import answer, answer_json, print_table, remark
from warmlink.orchestration.files import locked_folder
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.results import refuse_others
from warmlink.orchestration.shell import command

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.data.experiment import Experiment


COMMANDS = ("diagnose", "hide")


def diagnose(
    data: list[Path],
    *,
    assume: list[str] | None = None,
    set_: list[str] | None = None,
    scenario: str | None = None,
    noise: list[str] | None = None,
    accuracy: list[str] | None = None,
    unit: list[str] | None = None,
    map_: list[str] | None = None,
    decimal: str = "",
    replace: list[str] | None = None,
    calibrate_only: bool = False,
    time_limit: str | None = None,
    discover: bool | None = None,
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
    scenario : Scenario file (TOML) of your machine, with its [parameters]; --set changes them further.
    noise : Standard deviation of the noise of a column, for example --noise "tip_temperature=0.1 K".
        Repeatable.
    accuracy : Error that matters to you, for example --accuracy "0.5 K" for all temperatures or
        --accuracy "elongation=2 um". A model below it is adequate, however small the noise. Repeatable.
    unit : Unit that is missing from a header: --unit "T_base=degC" for one column, --unit degC for all
        columns of that quantity, --unit "time=%d/%m/%Y %H:%M:%S" for dates. Repeatable.
    map_ : Which variable a column holds, for example --map "T_base=base_temperature"; --map "T9=" ignores the
        column; --map link.heat_flow=Q what a replaced link calls its variable. Repeatable.
    decimal : Decimal mark, `comma` or `point`, if the file could be read either way.
    calibrate_only : Fit what the experiment calibrates, and look for no causes.
    time_limit : Longest time that --calibrate-only may take, for example --time-limit "2 min"; then the best
        numbers so far are told. Default: as long as it takes.
    discover : Look for an equation of the heat that the model lacks: where it enters, its terms with units
        and intervals; or that none earns its place. Default: where no cause is established.
    check : Show how the files are understood, and what looks wrong in them, without a diagnosis.
    out : Folder for results. Default: out/RUN/diagnose, or out/RUN+NEXT/diagnose for two runs.
    """
    from warmlink.orchestration.diagnosis.arm.measured import arm_experiments, is_arm_file
    from warmlink.orchestration.diagnosis.data.accuracy import with_accuracy
    from warmlink.orchestration.diagnosis.data.experiment import calibrating
    from warmlink.orchestration.diagnosis.data.inputs import of_scenario, with_noise
    from warmlink.orchestration.diagnosis.data.options import read_options
    from warmlink.orchestration.diagnosis.diagnose import read
    from warmlink.orchestration.machine import DEFAULT
    from warmlink.orchestration.system.replacement import Replacements
    from warmlink.orchestration.written.quantities import positive

    if time_limit is not None and not calibrate_only:
        raise InputError("--time-limit: applies only to a calibration; add --calibrate-only")
    limit = math.inf if time_limit is None else positive(time_limit, "s", "--time-limit")
    folder = out or Path("out") / "+".join(path.stem for path in data) / "diagnose"
    if not check:
        refuse_others(folder, "diagnose")
    whole_arm = [path for path in data if is_arm_file(path)]
    if whole_arm and not check:
        run = f"{whole_arm[0]}: a run of the whole arm"
        if len(data) > 1:
            raise InputError(f"{run} cannot be combined with others; diagnose it by itself")
        if any(
            (assume, set_, scenario, noise, accuracy, unit, map_, decimal, calibrate_only, replace, discover)
        ):
            raise InputError(
                f"{run} has every input and is compared with the shipped arm; "
                "leave out all options but --out, --check and --json"
            )

    def measured() -> Experiment:
        """The measurements, with the options that describe them."""
        machine, known = of_scenario(scenario) if scenario else (DEFAULT, {})
        given = {**known, **settings_given(set_)}
        parts = tuple(f"{each.partition('=')[0].strip()}." for each in replace or ())
        own = [name for name in map_ or () if parts and name.startswith(parts)]
        columns = [name for name in map_ or () if name not in own]
        told = read_options(unit or [], columns, decimal, Replacements.given(replace, own), machine)
        experiment = with_noise(read(data, assume or [], given, told), settings_given(noise, "--noise"))
        experiment = with_accuracy(experiment, accuracy or [])
        return calibrating(experiment, limit) if calibrate_only else experiment

    if check:
        _show(list(arm_experiments(data[0]).values()) if whole_arm else [measured()], bool(whole_arm), json)
        return
    with locked_folder(folder):
        if whole_arm:
            _diagnose_arm(data[0], folder, json)
        else:
            _diagnose_cell(data, measured, folder, json, discover)


def _show(experiments: list[Experiment], whole_arm: bool, json: bool) -> None:
    """Print how the files are understood."""
    from warmlink.orchestration.diagnosis.answer.doubtful import before_diagnosis
    from warmlink.orchestration.diagnosis.answer.slips import slips

    with spinner("Looking at the columns"):
        found = [
            {**each.understood(), "slips": slips(each).certain, "doubts": before_diagnosis(each)}
            for each in experiments
        ]
    if json:
        answer_json(found if whole_arm else found[0])
        return
    headings = ("column", "is", "unit", "cells", "least", "largest")
    for experiment in found:
        for run in experiment["runs"]:
            answer(_in_words(run))
            rows = []
            for each in run["columns"]:
                cells = (text.format(**each) for text in ("{unit} ({unit_from})", "{filled} of {cells}"))
                ends = ("" if each[end] is None else f"{each[end]:.5g}" for end in ("least", "largest"))
                rows.append((each["column"], each["variable"], *cells, *ends))
            print_table("", headings, rows, texts=3, width=120)
        for told in experiment["slips"]:
            answer(f"- likely slip: {told}")
        for told in experiment["doubts"]:
            answer(f"- look at this first: {told}")
        for told in experiment["remarks"]:
            answer(f"- {told}")


def _in_words(run: dict[str, Any]) -> str:
    """How a run is understood, in two lines, its columns aside."""
    gaps, pauses = run["gaps"], "no gaps"
    if gaps:
        longest = max(gaps, key=lambda gap: gap["lasts_s"])
        pauses = f"{len(gaps)} gaps, the longest {longest['lasts_s']:g} s from {longest['at_s']:g} s on"
    over = f"{run['duration_s'] / 60:.4g} min, one every {run['spacing_s']:g} s, {pauses}"
    held_out = ", held out" if run["held_out"] else ""
    return f"{run['name']}: {run['form']}\n{run['rows']} rows over {over}{held_out}"


def _diagnose_cell(
    paths: list[Path], measured: Callable[[], Experiment], folder: Path, json: bool, discover: bool | None
) -> None:
    from warmlink.orchestration.diagnosis.answer.extension import kinds_needed
    from warmlink.orchestration.diagnosis.answer.ladder import table_of
    from warmlink.orchestration.diagnosis.diagnose import SCENARIO, diagnose_experiment, work_out
    from warmlink.orchestration.diagnosis.terms.entries import content_with
    from warmlink.orchestration.diagnosis.terms.equation import discovered, is_due
    from warmlink.orchestration.diagnosis.terms.words import summary_with
    from warmlink.orchestration.fmu_store import store
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSP, extended_files, write_diagnosis

    with spinner(f"Diagnosing {', '.join(path.name for path in paths)}") as progress:
        progress("reading")
        found = diagnose_experiment(measured(), progress)
        equation = discovered(found, progress) if is_due(found, discover) else None
        found = found if equation is None else equation.diagnosis
        work_out(found, progress)
    for each in found.remarks:
        remark(each)
    with _answered(
        json,
        lambda: content_with(found, equation, *extended_files(found, True, equation)),
        lambda: summary_with(found, equation),
        folder,
    ):
        needed = kinds_needed(found.experiment.rig)
        with spinner("Writing the report"):
            files = write_diagnosis(found, folder, store(None, needed, remark), equation)
    if not json:
        headings, rows = table_of(found)
        if rows:
            print_table("", headings, rows, texts=1, width=160)
        word = {"uncorrected": "unchanged", "calibrated": "calibrated"}.get(found.delivered, "extended")
        model = f"    {word} model  {files[SSP]}" if SSP in files else "    no extended model"
        answer(f"report  {folder / PAGE}    figures  {folder / JSON}{model}")
        if following := files.get(SCENARIO):
            option = "--duty" if found.experiment.rig.system is None else "--scenario"
            told = command("warmlink", "hide", "EFFECT", option, following)
            answer(f"next    {following}    practise it: {told}")


def _diagnose_arm(path: Path, folder: Path, json: bool) -> None:
    from warmlink.orchestration.diagnosis.arm.diagnose import diagnose_arm
    from warmlink.orchestration.diagnosis.arm.measured import arm_experiments
    from warmlink.orchestration.report.diagnosis import JSON, PAGE, SSV, write_diagnoses

    with spinner(f"Diagnosing {path.name}") as progress:
        found = diagnose_arm(arm_experiments(path), progress=progress)
    whole = found.to_json(SSV)
    with _answered(json, lambda: whole, found.summary, folder), spinner("Writing the reports"):
        write_diagnoses(found.by_name, whole, folder)
    if not json:
        answer(f"figures  {folder / JSON}    reports  {folder / 'axis1' / PAGE} and so on")


@contextmanager
def _answered(
    json: bool, content: Callable[[], Any], summary: Callable[[], str], folder: Path
) -> Iterator[None]:
    """Print the answer; a failure to write after it becomes an InputError that says what is lost."""
    if json:
        answer_json(content())
    else:
        answer(summary())
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


def hide(
    effects: list[str] | None = None,
    *,
    duty: str | None = None,
    scenario: str | None = None,
    out: Path = Path("run.csv"),
    seed: int = 0,
    noise: str = "white",
    with_: str = "grid",
    axis: int | None = None,
    term: list[str] | None = None,
) -> None:
    """Make up a measured run that contains hidden effects, to practise `warmlink diagnose` on.

    The run is computed by another solver than the one that `diagnose` uses; that of your own machine by its
    FMUs.

    Parameters
    ----------
    effects : Effects to hide (`warmlink list`), for example radiation, joint_resistance=0.3 (a strength in SI
        units) or sensor_lag:tip_temperature. In your own machine joint_resistance:x_motor if it has several
        motors, or any parameter with its value in SI units: spindle.friction=3.
    duty : Duty cycle (CSV) or scenario (TOML), as for `warmlink run`. Default: two hours of varied work, or
        that of --scenario.
    scenario : Scenario file (TOML) of your machine: the run is of this machine, with its [parameters].
    out : CSV file to write.
    seed : Seed of the noise.
    noise : `white` noise, or `real`: correlated, rounded and with spikes.
    with_ : Solver that computes the run: `grid` (a rod) or `fea` (3-D finite elements).
    axis : Hide the effects in this axis of the six-axis arm, and record the whole arm.
    term : Heat by an equation: the place that it enters (shaft, winding, base or tip), the heat in W, and its
        parameters, for example --term "shaft: a * max(speed - b, 0)**1.5; a = 0.3; b = 0.5 rad/s".
        Repeatable.
    """
    from warmlink.orchestration.diagnosis.made_up import hide_effects, strengths_of
    from warmlink.orchestration.diagnosis.practice.effects import EFFECTS
    from warmlink.orchestration.diagnosis.practice.hide import write_csv

    if out.suffix != ".csv":
        raise InputError(f"--out {out}: not a CSV file; give a name that ends in .csv")
    machine = scenario if axis is None else None
    strengths = strengths_of(dict(map(_strength, effects or ())), machine)
    made = hide_effects(
        strengths, duty, scenario=scenario, seed=seed, noise=noise, solver=with_, axis=axis, terms=term or ()
    )
    write_csv({name: made[name].to_numpy() for name in made}, out)
    sizes = [f"{name} = {size:g}" for name, size in strengths.items()]
    hidden = ", ".join([*sizes, *(term or ())]) or "nothing"
    if axis is not None:
        answer(f"{out}: the six-axis arm with {hidden} hidden in axis {axis} (SI units, seed {seed})")
        return
    hours = made["time [s]"].iloc[-1] / 3600
    answer(f"{out}: {hours:.3g} h with {hidden} hidden (SI units, seed {seed})")
    if scenario is not None:
        answer(f"next     {command('warmlink', 'diagnose', out, '--scenario', scenario)}")
        return
    answer(f"effects  {len(EFFECTS)} can be hidden; warmlink list names them")


def _strength(given: str) -> tuple[str, float | None]:
    """Name of an effect, and its strength in SI units; None if none is given."""
    name, equals, size = given.partition("=")
    try:
        return name, float(size) if equals else None
    except ValueError:
        raise InputError(f"{given}: {size!r} is not a number; give the strength in SI units") from None
