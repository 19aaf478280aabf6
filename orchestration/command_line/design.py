"""`warmlink design`: a controller's gains for a system, as a parameter set for its FMU."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.command_line.options import Json, Set
from warmlink.orchestration.console import answer, answer_json, remark

if TYPE_CHECKING:
    from warmlink.controllers.design.plant import Network, Plant
    from warmlink.controllers.start_values import Values

WITH_CAMERA = "observer_drift"
"""The law that uses the camera."""


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
    from warmlink.controllers.design.gains import design_controller
    from warmlink.controllers.design.plant import Network, plant_model
    from warmlink.controllers.design.regression import fit_regression, training_run
    from warmlink.controllers.design.shipped import PLANT_FACTS
    from warmlink.fmus.component import SHORTEST_SAMPLE_TIME
    from warmlink.fmus.names import instead
    from warmlink.orchestration.command_line.options import settings_given
    from warmlink.orchestration.files import fresh_file
    from warmlink.orchestration.scenarios.quantity import positive
    from warmlink.orchestration.studies.design import write_design

    if out is not None and out.suffix != ".ssv":
        raise InputError(f"--out {out}: is no parameter set; name a file that ends in .ssv")
    if law not in PLANT_FACTS:
        raise InputError(f"--law {law}: {law!r} has no design; {instead(law, PLANT_FACTS)}")
    if report is not None and law == "regression":
        raise InputError(f"--report {report}: regression has no model to show; leave it out")
    if camera_std is not None and law != WITH_CAMERA:
        raise InputError(f"--camera-std {camera_std}: {law} does not go by the camera; {WITH_CAMERA} does")
    plant = _plant(system, law, settings_given(set_ or []))
    names = _names(sensors)
    noise, period = positive(sensor_std, "K", "--sensor-std"), positive(sample_time, "s", "--sample-time")
    if period < SHORTEST_SAMPLE_TIME:
        raise InputError(
            f"--sample-time {sample_time}: is too short; give at least {SHORTEST_SAMPLE_TIME:g} s"
        )
    facts: dict[str, object] = {"law": law, "sensors": names}
    if law == "regression":
        values: Values = {**fit_regression(training_run(plant), names, noise), "sample_time": period}
    else:
        camera = None if camera_std is None else positive(camera_std, "m", "--camera-std")
        design = design_controller(law, names, noise, period, plant, camera_std=camera)
        values = design.parameters
        error = design.reduced.error
        facts |= {
            "modes": design.reduced.order,
            "reduction_error_um": 1e6 * error.elongation_step,
            "reduction_error_K": error.temperature_step,
        }
    given = plant.given if isinstance(plant, Network) else plant.network.given
    facts["plant"] = dict(given)
    if report is not None:
        from warmlink.orchestration.report.design import write_report

        with fresh_file(report) as target:
            title = f"{law} for {Path(system).stem}"
            lead = f"{'; '.join(_answer(facts).splitlines())}."
            write_report(plant_model(plant), design.reduced, title, lead, target)
    path = out or Path(f"{law}.ssv")
    write_design(law, values, path)
    facts["values"] = str(path)
    if json:
        answer_json(facts)
    else:
        answer(_answer(facts))
        answer(f"values  {path}")


def _names(sensors: str) -> list[str]:
    names = [name.strip() for name in sensors.split(",") if name.strip()]
    if "none" not in names:
        return names
    if len(names) > 1:
        raise InputError(f"--sensors {sensors}: none goes with no other; leave it or them out")
    return []


def _plant(system: str, law: str, given: dict[str, str]) -> Plant | Network:
    """What to design for, other parameters given."""
    from warmlink.orchestration.studies.design import network_of, with_values

    if not system.endswith(".toml"):
        return with_values(_cell(system), given)
    from warmlink.orchestration.scenarios.changes import changed
    from warmlink.orchestration.scenarios.load import load_scenario

    return network_of(changed(load_scenario(system), controller=law, parameters=given))


def _cell(system: str) -> Plant:
    from warmlink.controllers.design.plant import Plant
    from warmlink.orchestration.files import temporary_folder
    from warmlink.orchestration.studies.design import plant_of
    from warmlink.orchestration.system.read import read_system
    from warmlink.orchestration.system.shipped import SHIPPED, WARMUP_CELL

    if system in SHIPPED:
        if system != WARMUP_CELL.name:
            raise InputError(
                f"{system}: has no motor with a link; design for {WARMUP_CELL.name} or an .ssp of your own"
            )
        return Plant()
    with temporary_folder() as work:
        read = read_system(Path(system), work)
        for told in read.remarks:
            remark(told)
        return plant_of(read)


def _answer(facts: Mapping[str, Any]) -> str:
    changed = list(facts["plant"])
    lines = [f"{facts['law']} from {', '.join(facts['sensors']) or 'the duty alone'}"]
    if "modes" in facts:
        elongation, temperature = facts["reduction_error_um"], facts["reduction_error_K"]
        lines.append(
            f"{facts['modes']} modes; the reduction costs at most {elongation:.2g} µm and {temperature:.2g} K"
        )
    lines.append(f"plant: {listed(changed) + ' changed from nominal' if changed else 'nominal'}")
    return "\n".join(lines)
