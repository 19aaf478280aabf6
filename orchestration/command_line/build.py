"""`warmlink build` and `save`: FMUs and systems for other tools."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import advise, values_given
from warmlink.orchestration.console import answer, answer_json, remark
from warmlink.orchestration.shell import command

COMMANDS = ("build", "save")


def build(
    names: list[str] | None = None,
    *,
    fmus: str = "all",
    fmi: str | None = None,
    ssp: str = "1",
    platforms: str | None = None,
    scenario: Path | None = None,
    out: Path = Path("dist"),
    valid_flags: bool = False,
    arrays: bool = False,
    json: bool = False,
) -> None:
    """Build the FMUs and the systems (SSP) for other tools, and validate each of them.

    Example: `warmlink build ThermalLink observer WarmupCell --fmi 3`

    Parameters
    ----------
    names : Components, controllers and systems to build, as `ThermalLink`, a system with the FMUs that it
        holds. Default: all.
    fmus : Which FMUs: `native` (C), `python` or `all`.
    fmi : Version of FMI of the native FMUs: `2` or `3`. Default: both; the systems hold those of FMI 2.0.
    ssp : Version of SSP of the systems: `1`, which all tools read, or `2`.
    platforms : Platforms of the native FMUs, such as `x86_64-linux,x86-windows`, or `all` of 64 bits.
        Default: this machine's.
    scenario : A scenario (TOML) of your own: build its system alone, as FMUs and SSP.
    out : Folder to build into.
    valid_flags : Native FMUs without NaN: a reading that is missing holds its last value, and a Boolean
        beside it (`reading_valid[1]`) says so.
    arrays : FMUs of FMI 3.0 with arrays: `reading` in place of `reading[1]`, `reading[2]` ...
    """
    from warmlink.orchestration.products.build import build as build_files

    built = build_files(
        names or (),
        out,
        fmus=fmus,
        fmi=fmi,
        ssp=ssp,
        platforms=platforms,
        scenario=scenario,
        valid_flags=valid_flags,
        arrays=arrays,
    )
    if json:
        answer_json([str(path) for path in built])
    else:
        for path in built:
            answer(f"{path.stat().st_size / 1024:8.0f} KiB  {path}")


def save(
    scenario: str,
    *,
    controller: str | None = None,
    fmus: str | None = None,
    set_: list[str] | None = None,
    parameters: list[Path] | None = None,
    ssp: str = "1",
    out: Path | None = None,
) -> None:
    """Write a scenario's system, with its duty cycle and controller, as an SSP with its parameter sets (SSV).

    Example: `warmlink save my_cell.toml --parameters observer.ssv --out my_cell.ssp`

    Parameters
    ----------
    scenario : A scenario (TOML) of your own, or a shipped one by name.
    controller : Controller. Default: the scenario's.
    ssp : Version of SSP: `1`, which all tools read, or `2`.
    out : SSP to write. Default: SCENARIO.ssp.
    """
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.fmu_store import kind_named, store
    from warmlink.orchestration.scenarios.scenario import changed
    from warmlink.orchestration.system.write import ssp_version_named, write_ssp

    if out is not None and out.suffix != ".ssp":
        raise InputError(f"--out {out}: is no system; name a file that ends in .ssp")
    version, given = ssp_version_named(ssp, "ssp"), values_given(parameters, set_)
    asked = changed(load_scenario(scenario), controller=controller, parameters=given)
    path = out or Path(f"{asked.name}.ssp")
    built = store(kind_named(fmus), sorted(asked.kinds), remark)
    write_ssp(asked.system(asked.files(built)), path, version=version)
    advise(asked)
    answer(f"system  {path}    run it: {command('warmlink', 'simulate', path)}")
