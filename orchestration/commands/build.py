"""`warmlink build`: FMUs and systems for other tools, each validated."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.python.fmu import build_python_fmus
from warmlink.orchestration.catalogue import controller, entries
from warmlink.orchestration.commands.console import answer, answer_json, counted, progress_bar
from warmlink.orchestration.scenarios.load import load_scenario
from warmlink.orchestration.system.shipped import SHIPPED, WARMUP_CELL, Blueprint
from warmlink.orchestration.system.write import write_ssp

JOINED_HOME = "warmlink.orchestration.system.shipped"
"""Module beside whose README the documentation of joined systems lies."""

KINDS = ("native", "python", "all")
SHOWN_CONTROLLER = "lag"
"""Controller that the shipped WarmupCell.ssp holds; any other FMU of the same connectors may replace it."""

SHOWN_ARM_SCENARIO = "six_axis_shift"
"""What the shipped SixAxisArm.ssp does unless it is told otherwise."""


def build_command(kind: str, platforms: str | None, out: Path, as_json: bool) -> None:
    """Build, validate and list what was built."""
    if kind not in KINDS:
        raise InputError(f"--fmus {kind}: no such kind; {instead(kind, KINDS)}")
    try:
        built = _build(kind, platforms, out)
    except OSError as fault:
        place = Path(fault.filename or out)
        shown = out if place.is_relative_to(out) else place
        raise InputError(f"{shown}: cannot be written ({fault.strerror}); choose another --out") from None
    _validate(built)
    if as_json:
        answer_json([str(path) for path in built])
    else:
        for path in built:
            answer(f"{path.stat().st_size / 1024:8.0f} KiB  {path}")


def _build(kind: str, platforms: str | None, out: Path) -> list[Path]:
    """Build everything; each file is whole or not there."""
    built: list[Path] = []
    everything = list(entries().values())
    if kind in ("python", "all"):
        with progress_bar("Python FMUs") as progress:
            built += build_python_fmus(everything, out, counted(progress, len(everything)))
    if kind in ("native", "all"):
        built += _build_native(everything, platforms, out)
        built += _build_joined(platforms, out)
    fmus = {path.stem: path for path in built}
    for blueprint in SHIPPED.values():
        built.append(_write_system(blueprint, fmus, out))
    return built + _write_arm(fmus, out)


def _build_joined(platforms: str | None, out: Path) -> list[Path]:
    """Cell and arm, each as one FMU, for tools that read no SSP."""
    cell = WARMUP_CELL.joined(controller(SHOWN_CONTROLLER).name)
    scenario = load_scenario(SHOWN_ARM_SCENARIO)
    arm = scenario.joined(controller(scenario.controller))
    return _build_native([Entry(each, JOINED_HOME) for each in (cell, arm)], platforms, out)


def _build_native(everything: list[Entry], platforms: str | None, out: Path) -> list[Path]:
    from warmlink.fmus.packaging.native.compile import platforms_named
    from warmlink.fmus.packaging.native.fmu import FmiVersion, build_native_fmus

    chosen = platforms_named(platforms)
    built: list[Path] = []
    versions: tuple[FmiVersion, ...] = ("3.0", "2.0")
    for version in versions:
        with progress_bar(f"native FMUs, FMI {version}") as progress:
            folder = out / "native" / f"fmi{version[0]}"
            built += build_native_fmus(
                everything, folder, version, chosen, counted(progress, len(everything))
            )
    return built


def _write_system(blueprint: Blueprint, fmus: dict[str, Path], out: Path) -> Path:
    path = out / f"{blueprint.name}.ssp"
    write_ssp(blueprint.system(fmus, controller(SHOWN_CONTROLLER).name), path)
    return path


def _write_arm(fmus: dict[str, Path], out: Path) -> list[Path]:
    """The arm in its shift, nested and flat, with an observer an axis."""
    from warmlink.orchestration.arm.blueprint import write_arm

    scenario = load_scenario(SHOWN_ARM_SCENARIO)
    return write_arm(scenario.system(fmus, controller(scenario.controller)), out)


def _validate(built: list[Path]) -> None:
    """Hold every file against the standards' schemas and rules.

    Raises
    ------
    InputError
        If one does not pass, which is a fault of warmlink and not of its user.
    """
    import tempfile

    from fmpy.validation import validate_fmu

    from warmlink.orchestration.system.read import read_system

    for path in built:
        if path.suffix == ".fmu":
            problems = validate_fmu(str(path))
            if problems:
                raise InputError(f"{path}: {problems[0]}; please report this")
        else:
            with tempfile.TemporaryDirectory(prefix="warmlink-") as work:
                read_system(path, Path(work))
