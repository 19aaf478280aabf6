"""`warmlink design` and `export`: a controller's gains for a system, and its C."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import listed, settings_given
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.files import fresh_file

COMMANDS = ("design", "export")


def design(
    system: str,
    *,
    law: str = "observer",
    sensors: str | None = None,
    sensor_std: str | None = None,
    camera_std: str | None = None,
    sample_time: str = "1 s",
    set_: list[str] | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    out: Path | None = None,
    report: Path | None = None,
    json: bool = False,
) -> None:
    """Compute a controller's gains for a system, and write them as a parameter set (SSV) for its FMU.

    The plant model takes its parameters from the system's motors and links, changed by --set. For a scenario,
    the connections and the table [roles] say which inputs are driven and which output is scored.

    Example: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`

    Parameters
    ----------
    system : `WarmupCell`, an .ssp file with one motor and one link, or a scenario file (TOML) with any number
        of motors and links; for `regression`, with any FMUs.
    law : `observer`, `observer_drift` or `regression`.
    sensors : Thermometers that the law uses: any of `shaft,winding,base,middle,tip`, or `none`. Default:
        those that the scenario says, or base and tip.
    sensor_std : Standard deviation of a thermometer's noise. Default: the scenario's, or 0.1 K.
    camera_std : Standard deviation of the camera's noise, such as "0.2 um". Default: that of DriftCamera.
    sample_time : Time between two corrections.
    out : Parameter set (SSV) to write. Default: LAW.ssv.
    report : HTML page to write: expected error, what each thermometer is worth, gains and poles of the
        filter, Bode plots, and the error of the reduced model (not for `regression`).
    """
    from warmlink.orchestration.studies.design import design as design_law
    from warmlink.orchestration.system.replacement import Replacements

    if out is not None and out.suffix != ".ssv":
        raise InputError(f"--out {out}: is no parameter set; name a file that ends in .ssv")
    if report is not None and law == "regression":
        raise InputError(f"--report {report}: regression has no model to show; leave it out")
    found = design_law(
        system,
        law,
        _names(sensors),
        sensor_std=sensor_std,
        camera_std=camera_std,
        sample_time=sample_time,
        parameters=settings_given(set_),
        replaced=Replacements.given(replace, map_),
    )
    if report is not None and found.reduced is not None and found.plant is not None:
        from warmlink.controllers.design.plant import plant_model
        from warmlink.orchestration.report.design import write_report

        title, lead = f"{law} for {Path(system).stem}", f"{'; '.join(found.summary().splitlines())}."
        with fresh_file(report) as target:
            write_report(plant_model(found.plant), found.reduced, found.values, title, lead, target)
    path = out or Path(f"{law}.ssv")
    found.write(path)
    if json:
        answer_json({**found.to_dict(), "values": str(path)})
    else:
        answer(found.summary())
        answer(f"values  {path}")


def _names(sensors: str | None) -> list[str] | None:
    names = listed(sensors)
    if not names or "none" not in names:
        return names
    if len(names) > 1:
        raise InputError(
            f"--sensors {sensors}: none cannot be combined with thermometers; give either none or their names"
        )
    return []


def export(
    law: str,
    *,
    design: Path | None = None,
    precision: Literal["double", "single"] = "double",
    out: Path | None = None,
) -> None:
    """Write a controller's law as C99 for a robot's or machine's own controller.

    The folder contains the core (a struct, `init` and `step`; no heap, no files, no variables of its own), a
    program that tests it, and a README with its sample time, memory and number of operations.

    Example: `warmlink export observer --design observer.ssv --precision single --out plc`

    Parameters
    ----------
    law : Controller, as `observer`, or a law of your own, as `my_law.py:MyLaw`.
    design : Parameter set (SSV) from `warmlink design`. Default: the design that ships.
    precision : Of the arithmetic.
    out : Folder to write. Default: LAW.
    """
    from warmlink.orchestration.products.export import export as export_law

    found = export_law(law, design, precision=precision)
    folder = out or Path(found.name)
    found.write(folder)
    step = f"{found.core.operations()} operations in a step of {found.core.period:g} s"
    answer(f"core  {folder / found.name}.c    {step}")
