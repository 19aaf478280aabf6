"""`warmlink design`: a controller's gains for a system, as a parameter set for its FMU."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import Json, Set
from warmlink.orchestration.console import answer, answer_json


def design(
    system: Annotated[
        str,
        typer.Argument(
            help="`WarmupCell`, an .ssp with one motor and one link, "
            "or a scenario (TOML) of any motors and links."
        ),
    ],
    law: Annotated[str, typer.Option(help="`observer`, `observer_drift` or `regression`.")] = "observer",
    sensors: Annotated[
        str,
        typer.Option(
            help="Thermometers that the law uses: any of `shaft,winding,base,middle,tip`, or `none`."
        ),
    ] = "base,tip",
    sensor_std: Annotated[
        str, typer.Option(help="Standard deviation of the noise of a thermometer.")
    ] = "0.1 K",
    camera_std: Annotated[
        str | None,
        typer.Option(
            help='Standard deviation of the noise of the camera, as "0.2 um". Default: that of DriftCamera.'
        ),
    ] = None,
    sample_time: Annotated[str, typer.Option(help="Time between two corrections.")] = "1 s",
    set_: Set = None,
    out: Annotated[Path | None, typer.Option(help="Parameter set to write. Default: LAW.ssv.")] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            help="Page to write, with poles, Bode plots and what the reduction costs (not for `regression`)."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Work out a controller's gains for a system, as a parameter set (SSV) for the controller's FMU.

    The plant has the parameters of the system's motors and links, changed by --set. For a scenario, what
    drives, reads and scores follows from its wires and roles.

    Example: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`
    """
    from warmlink.orchestration.command_line.options import settings_given
    from warmlink.orchestration.studies.design import design as design_law

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
        parameters=settings_given(set_ or []),
    )
    if report is not None and found.reduced is not None:
        from warmlink.controllers.design.plant import plant_model
        from warmlink.orchestration.files import fresh_file
        from warmlink.orchestration.report.design import write_report

        title, lead = f"{law} for {Path(system).stem}", f"{'; '.join(found.summary().splitlines())}."
        with fresh_file(report) as target:
            write_report(plant_model(found.plant), found.reduced, title, lead, target)
    path = out or Path(f"{law}.ssv")
    found.write(path)
    if json:
        answer_json({**found.to_dict(), "values": str(path)})
    else:
        answer(found.summary())
        answer(f"values  {path}")


def _names(sensors: str) -> list[str]:
    names = [name.strip() for name in sensors.split(",") if name.strip()]
    if "none" not in names:
        return names
    if len(names) > 1:
        raise InputError(f"--sensors {sensors}: none goes with no other; leave it or them out")
    return []
