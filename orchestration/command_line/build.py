"""`warmlink build`, `save` and `check`: FMUs and systems for other tools, checked as their users would."""

from __future__ import annotations

import re
import shlex
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import advise, values_given
from warmlink.orchestration.console import (
    FAILED,
    Progress,
    answer,
    answer_json,
    counted,
    print_table,
    progress_bar,
    remark,
    spinner,
)
from warmlink.orchestration.files import fresh_folder, temporary_folder
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.shell import command

if TYPE_CHECKING:
    from collections.abc import Sequence

    from warmlink.fmus.catalogue import Entry
    from warmlink.orchestration.check.fmu import CheckResult
    from warmlink.orchestration.scenarios.scenario import Scenario

KINDS = ("native", "python", "all")
SHOWN_CONTROLLER = "lag"
"""Controller in the shipped WarmupCell.ssp; any FMU with the same connectors can replace it."""

SHOWN_ARM_SCENARIO = "six_axis_shift"
"""Scenario that the shipped SixAxisArm.ssp runs by default."""

JOINED_HOME = "warmlink.orchestration.system.shipped"
"""Module that stands for the joined systems; beside it is no README, so that their page is of variables."""

_SIGNS = {
    "pass": ("pass", "green"),
    "fail": ("FAIL", "red"),
    "skip": ("skip", "yellow"),
    "remark": ("note", "yellow"),
}


def build(
    *,
    fmus: str = "all",
    platforms: str | None = None,
    scenario: Path | None = None,
    out: Path = Path("dist"),
    valid_flags: bool = False,
    arrays: bool = False,
    json: bool = False,
) -> None:
    """Build the FMUs and the systems (SSP) for other tools, and validate each of them.

    Parameters
    ----------
    fmus : Which FMUs: `native` (C), `python` or `all`.
    platforms : Platforms of the native FMUs, such as `x86_64-linux,x86-windows`, or `all` of 64 bits.
        Default: this machine's.
    scenario : A scenario (TOML) of your own: build its system alone, as FMUs and SSP.
    out : Folder to build into.
    valid_flags : Native FMUs without NaN: a reading that is missing holds its last value, and a Boolean
        beside it (`reading_valid[1]`) says so.
    arrays : FMUs of FMI 3.0 with arrays: `reading` in place of `reading[1]`, `reading[2]` ...
    """
    built = build_files(out, fmus, platforms, scenario, valid_flags, arrays)
    if json:
        answer_json([str(path) for path in built])
    else:
        for path in built:
            answer(f"{path.stat().st_size / 1024:8.0f} KiB  {path}")


def build_files(
    out: str | Path = "dist",
    fmus: str = "all",
    platforms: str | None = None,
    scenario: str | Path | None = None,
    valid_flags: bool = False,
    arrays: bool = False,
) -> list[Path]:
    """Build the FMUs and the systems (SSP) for other tools, validate each of them, and give their files.

    Parameters
    ----------
    out : folder
    fmus : native, python or all
    platforms : of the native FMUs, such as `x86_64-linux,x86_64-windows`, or all; this machine's by default
    scenario : file (TOML) of a system of one's own, which is built in place of the shipped ones
    valid_flags : without NaN, with a flag beside each reading; of the shipped components and systems in
        native FMUs
    arrays : arrays in the native FMUs of FMI 3.0

    Raises
    ------
    InputError
        If the kind or a platform does not exist, or the folder cannot be written.
    """
    from warmlink.fmus.names import instead

    if fmus not in KINDS:
        raise InputError(f"--fmus {fmus}: no such kind; {instead(fmus, KINDS)}")
    if valid_flags and (fmus != "native" or scenario is not None):
        raise InputError("--valid-flags: is for the shipped native FMUs; give --fmus native, no --scenario")
    from warmlink.orchestration.check.fmu import validity_problems
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.system.assemble import read_system

    out = Path(out)
    own = None if scenario is None else load_scenario(str(scenario))
    if own is not None:
        advise(own)
    with fresh_folder(out) as fresh:
        try:
            built = _build(fmus, platforms, fresh, own, valid_flags, arrays)
        except OSError as fault:
            place = Path(fault.filename or fresh)
            shown = out if place.is_relative_to(fresh) else place
            raise InputError(f"{shown}: cannot be written ({fault.strerror}); choose another --out") from None
        for path in built:
            if path.suffix != ".fmu":
                with temporary_folder() as work:
                    read_system(path, work)
            elif problems := validity_problems(path):
                raise InputError(f"{path.name}: {problems[0]}; please report this")
    return [out / path.relative_to(fresh) for path in built]


def _build(
    kind: str, platforms: str | None, out: Path, own: Scenario | None, flags: bool, arrays: bool
) -> list[Path]:
    from warmlink.fmus.catalogue import Entry
    from warmlink.fmus.packaging.python.fmu import build_python_fmus
    from warmlink.fmus.packaging.views import flagged
    from warmlink.orchestration.arm.blueprint import write_arm
    from warmlink.orchestration.catalogue import controller, entries
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.fmu_store import FmuStore
    from warmlink.orchestration.system.shipped import SHIPPED, WARMUP_CELL
    from warmlink.orchestration.system.write import write_ssp

    law, arm = controller(SHOWN_CONTROLLER), load_scenario(SHOWN_ARM_SCENARIO)
    components = [each for name, each in entries().items() if own is None or name in own.kinds]
    with_flags = flagged if flags else lambda component: component
    components = [replace(each, component=with_flags(each.component)) for each in components]
    built: list[Path] = []
    if kind != "native":
        with progress_bar("Python FMUs") as progress:
            built += build_python_fmus(components, out / "python", counted(progress, len(components)))
    if kind != "python":
        built += _build_native(components, platforms, out, arrays)
        shipped = [with_flags(WARMUP_CELL.joined(law)), with_flags(arm.joined())]
        if own is not None:  # as one component, called as the scenario is; none where others' FMUs are in it
            name, apart = re.sub(r"\W", "_", own.name), own.setup.blueprint.never_joined
            shipped = [] if apart else [replace(own.joined(), name=name)]
        built += _build_native([Entry(each, JOINED_HOME) for each in shipped], platforms, out, arrays)
    fmus = {path.stem: path for path in built}
    if own is not None:
        built.append(out / f"{own.name}.ssp")
        store = FmuStore("python" if kind == "python" else "native")
        write_ssp(own.system({**fmus, **own.controller.files(store)}), built[-1])
        return built
    for blueprint in SHIPPED.values():
        built.append(out / f"{blueprint.name}.ssp")
        write_ssp(blueprint.system(fmus, law.name, blueprint.shown_drive), built[-1])
        if blueprint.ports:
            built.append(out / f"{blueprint.name}-ports.ssp")
            write_ssp(blueprint.system(fmus, law.name), built[-1], blueprint.ports)
    return built + write_arm(arm.system(fmus), out)


def _build_native(components: Sequence[Entry], platforms: str | None, out: Path, arrays: bool) -> list[Path]:
    from warmlink.fmus.packaging.native.compile import platforms_named
    from warmlink.fmus.packaging.native.fmu import FmiVersion, build_native_fmus

    chosen = platforms_named(platforms)
    built: list[Path] = []
    versions: tuple[FmiVersion, ...] = ("3.0", "2.0")
    for version in versions:
        with progress_bar(f"native FMUs, FMI {version}") as progress:
            folder, done = out / "native" / f"fmi{version[0]}", counted(progress, len(components))
            built += build_native_fmus(components, folder, version, chosen, done, arrays)
    return built


def save(
    scenario: str,
    *,
    controller: str | None = None,
    fmus: str | None = None,
    set_: list[str] | None = None,
    parameters: list[Path] | None = None,
    out: Path | None = None,
) -> None:
    """Write a scenario's system, with its duty cycle and controller, as an SSP with its parameter sets (SSV).

    Example: `warmlink save my_cell.toml --parameters observer.ssv --out my_cell.ssp`

    Parameters
    ----------
    scenario : A scenario (TOML) of your own, or a shipped one by name.
    controller : Controller. Default: the scenario's.
    out : SSP to write. Default: SCENARIO.ssp.
    """
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.fmu_store import kind_named, store
    from warmlink.orchestration.scenarios.scenario import changed
    from warmlink.orchestration.system.write import write_ssp

    if out is not None and out.suffix != ".ssp":
        raise InputError(f"--out {out}: is no system; name a file that ends in .ssp")
    given = values_given(parameters, set_)
    asked = changed(load_scenario(scenario), controller=controller, parameters=given)
    path = out or Path(f"{asked.name}.ssp")
    built = store(kind_named(fmus), sorted(asked.kinds), remark)
    write_ssp(asked.system(asked.files(built)), path)
    advise(asked)
    answer(f"system  {path}    run it: {command('warmlink', 'simulate', path)}")


def check(file: Path, *, time_limit: str | None = None, json: bool = False) -> None:
    """Check an FMU or a system as its user would check it; the exit code is 1 if a check fails.

    Parameters
    ----------
    file : An .fmu or .ssp file from any tool.
    time_limit : Longest time that one check of an FMU may take. Default: "30 s".
    """
    from rich.text import Text

    from warmlink.orchestration.check.fmu import TIME_LIMIT, check_fmu
    from warmlink.orchestration.scenarios.quantities import positive

    if file.is_dir():
        raise InputError(_folder(file))
    limit = TIME_LIMIT if time_limit is None else positive(time_limit, "s", "--time-limit")
    with spinner(f"Checking {file.name}") as progress:
        system = file.suffix == ".ssp"
        results = _check_system(file, progress) if system else check_fmu(file, limit, progress=progress)
    failed = sum(result.verdict == "fail" for result in results)
    if json:
        answer_json([asdict(result) for result in results])
    else:
        rows = [(result.name, Text(*_SIGNS[result.verdict]), result.detail) for result in results]
        print_table(str(file), ("check", "", "detail"), rows)
        answer(f"{len(results) - failed} of {len(results)} checks found no fault")
    if failed:
        raise SystemExit(FAILED)


_NAMED = 5
"""Files of a folder, at most, that a sentence names."""


def _folder(folder: Path) -> str:
    """Say what a folder holds that can be checked."""
    if (folder / "modelDescription.xml").is_file():
        return f"{folder}: is an unpacked FMU; pack it into a zip archive named .fmu"
    files = sorted(path for kind in ("fmu", "ssp") for path in folder.rglob(f"*.{kind}"))
    if not files:
        return f"{folder}: is a folder without .fmu or .ssp files; give the path of one"
    names = ", ".join(str(path.relative_to(folder)) for path in files[:_NAMED])
    more = f" and {len(files) - _NAMED} more" if len(files) > _NAMED else ""
    one = shlex.quote(str(files[0]))
    return f"{folder}: is a folder, which holds {names}{more}; check one of them: warmlink check {one}"


def _check_system(path: Path, progress: Progress) -> list[CheckResult]:
    """Check a system: that it reads, that each FMU is valid, and that it runs its default experiment."""
    from warmlink.orchestration.check.fmu import CheckResult, validity_problems
    from warmlink.orchestration.simulation import simulate
    from warmlink.orchestration.system.assemble import read_system

    with temporary_folder() as work:
        system = read_system(path, work)
        detail = f"{len(system.components)} components, {len(system.connections)} connections"
        results = [CheckResult("reads and fits together", "pass", detail)]
        for k, (name, held) in enumerate(system.components.items()):
            progress(f"{name} is valid", k / (1 + len(system.components)))
            found = "; ".join(validity_problems(held.fmu))[:200]
            results.append(CheckResult(f"{name} is valid", "fail" if found else "pass", found))
        stop = system.default_experiment.stop_time
        if stop is None:
            return [*results, CheckResult("runs", "skip", "the system proposes no stop time")]
        try:
            run = simulate(system)
        except SlaveError as fault:
            return [*results, CheckResult("runs", "fail", str(fault))]
    done = "; ".join((f"{stop:g} s in steps of {run.table.points.step_size:g} s", *run.remarks))
    return [*results, CheckResult("runs", "fail" if run.stopped else "pass", run.stopped or done)]
