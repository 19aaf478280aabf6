"""`warmlink design`: compute a controller's gains for a system, as a parameter set for its FMU."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import Argument, Json, Option, Rename, Replace, Set
from warmlink.orchestration.console import answer, answer_json


def design(
    system: Annotated[
        str,
        Argument(
            help="`WarmupCell`, an .ssp file with one motor and one link, "
            "or a scenario file (TOML) with any number of motors and links; for `regression`, with any FMUs."
        ),
    ],
    law: Annotated[str, Option(help="`observer`, `observer_drift` or `regression`.")] = "observer",
    sensors: Annotated[
        str | None,
        Option(
            help="Thermometers that the law uses: any of `shaft,winding,base,middle,tip`, or `none`. "
            "Default: those that the scenario says, or base and tip."
        ),
    ] = None,
    sensor_std: Annotated[
        str | None,
        Option(help="Standard deviation of a thermometer's noise. Default: the scenario's, or 0.1 K."),
    ] = None,
    camera_std: Annotated[
        str | None,
        Option(
            help='Standard deviation of the camera\'s noise, such as "0.2 um". Default: that of DriftCamera.'
        ),
    ] = None,
    sample_time: Annotated[str, Option(help="Time between two corrections.")] = "1 s",
    set_: Set = None,
    replace: Replace = None,
    map_: Rename = None,
    out: Annotated[Path | None, Option(help="Parameter set (SSV) to write. Default: LAW.ssv.")] = None,
    report: Annotated[
        Path | None,
        Option(
            help="HTML page to write: poles, Bode plots, and the error of the reduced model (not for "
            "`regression`)."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Compute a controller's gains for a system, and write them as a parameter set (SSV) for its FMU.

    The plant model takes its parameters from the system's motors and links, changed by --set. For a scenario,
    the connections and the table [roles] say which inputs are driven and which output is scored.

    Example: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`
    """
    from warmlink.orchestration.command_line.options import settings_given
    from warmlink.orchestration.studies.design import design as design_law
    from warmlink.orchestration.system.replacement import Replacements

    if out is not None and out.suffix != ".ssv":
        raise InputError(f"--out {out}: is no parameter set; name a file that ends in .ssv")
    if report is not None and law == "regression":
        raise InputError(f"--report {report}: regression has no model to show; leave it out")
    found = design_law(
        system,
        law,
        None if sensors is None else _names(sensors),
        sensor_std=sensor_std,
        camera_std=camera_std,
        sample_time=sample_time,
        parameters=settings_given(set_ or []),
        replaced=Replacements.given(replace, map_),
    )
    if report is not None and found.reduced is not None and found.plant is not None:
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
        raise InputError(
            f"--sensors {sensors}: none cannot be combined with thermometers; give either none or their names"
        )
    return []
