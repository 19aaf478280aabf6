"""`warmlink design` and `export`: a controller's gains for a system, and its C."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import listed, settings_given
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.files import fresh_file

COMMANDS = ("design", "export")


def design(
    system: list[str] | None = None,
    *,
    law: str = "observer",
    data: list[Path] | None = None,
    scenario: str | None = None,
    sensors: str | None = None,
    sensor_std: str | None = None,
    camera_std: str | None = None,
    sample_time: str = "1 s",
    set_: list[str] | None = None,
    replace: list[str] | None = None,
    map_: list[str] | None = None,
    unit: list[str] | None = None,
    decimal: str = "",
    out: Path | None = None,
    report: Path | None = None,
    json: bool = False,
) -> None:
    """Compute a controller's gains for a system, and write them as a parameter set (SSV) for its FMU.

    With --data a law is learnt from measured logs instead, and no model of the machine is needed: the growth
    may have been measured only now and then. A model, as --scenario, helps where little was measured.

    The plant model takes its parameters from the system's motors and links, changed by --set. For a scenario,
    the connections and the table [roles] say which inputs are driven and which output is scored. With --law
    linear_observer the model of a machine whose FMUs nobody here made is found from runs of them, and it is
    said what the law is worth in runs that it was not made from.

    Examples: `warmlink design WarmupCell --law observer --sensors shaft --out shaft_only.ssv`,
    `warmlink design spindle.toml --law linear_observer`,
    `warmlink design --law regression --data log.csv --report law.html`

    Parameters
    ----------
    system : `WarmupCell`, an .ssp file with one motor and one link, or a scenario file (TOML) with any number
        of motors and links; for `linear_observer` and `regression`, with any FMUs. With --data: further logs.
    law : `observer`, `observer_drift`, `linear_observer` or `regression`.
    data : Logs of one machine to learn a law from, as a logger or a spreadsheet writes them (CSV,
        text, Parquet, Excel), with columns as `base_temperature [degC]` and `elongation [um]`. Repeatable.
    scenario : With --data: a scenario file (TOML) of any machine. Its roles say which variables the columns
        are; its model helps, if its equations are known.
    sensors : Thermometers that the law uses: any of `shaft,winding,base,middle,tip`, or `none`. Default:
        those that the scenario says, or base and tip; with --data those that are worth it.
    sensor_std : Standard deviation of a thermometer's noise. Default: the scenario's, or 0.1 K; with --data
        the one that the logs show.
    camera_std : Standard deviation of the camera's noise, such as "0.2 um". Default: that of DriftCamera.
    sample_time : Time between two corrections.
    unit : With --data: unit that is missing from a header, as --unit "T_base=degC". Repeatable.
    map_ : What the FMU that replaces a part calls a variable, as --map link.heat_flow=Q; with --data: which
        variable a column holds, as --map "T_base=base_temperature". Repeatable.
    decimal : With --data: decimal mark, `comma` or `point`, if a log could be read either way.
    out : Parameter set (SSV) to write. Default: LAW.ssv.
    report : HTML page to write: expected error, what each thermometer is worth, gains and poles of the
        filter, Bode plots, and the error of the reduced model; with --data the law, its errors, what each
        thermometer is worth, and how much log is enough.
    """
    if out is not None and out.suffix != ".ssv":
        raise InputError(f"--out {out}: is no parameter set; name a file that ends in .ssv")
    path = out or Path(f"{law}.ssv")
    if data:
        from warmlink.orchestration.command_line.logs import learn

        logs = [*data, *map(Path, system or ())]
        if replace:
            raise InputError("--replace: a law that is learnt from logs has no model; leave it out")
        stds = sensor_std, camera_std
        options = law, _names(sensors), stds, sample_time, scenario, settings_given(set_)
        learn(logs, *options, unit or [], map_ or [], decimal, path, report, json)
        return
    if scenario is not None or unit or decimal:
        option = "--scenario" if scenario is not None else "--unit" if unit else "--decimal"
        raise InputError(f"{option}: belongs to --data; name the system or scenario before the options")
    if len(system or ()) != 1:
        raise InputError("design: needs one system to design for, or logs: --data LOG")
    _design(
        (system or [""])[0],
        law,
        _names(sensors),
        (sensor_std, camera_std, sample_time),
        settings_given(set_),
        (replace, map_),
        path,
        report,
        json,
    )


def _design(
    system: str,
    law: str,
    sensors: list[str] | None,
    figures: tuple[str | None, str | None, str],
    settings: Mapping[str, str],
    replaced: tuple[list[str] | None, list[str] | None],
    path: Path,
    report: Path | None,
    json: bool,
) -> None:
    """Design for a model; `figures` are sensor_std, camera_std and sample_time."""
    from warmlink.orchestration.studies.design import Designed
    from warmlink.orchestration.studies.design import design as design_law
    from warmlink.orchestration.system.replacement import Replacements

    if report is not None and law in ("regression", "linear_observer"):
        raise InputError(f"--report {report}: {law} has no model to show; leave it out")
    sensor_std, camera_std, sample_time = figures
    found = design_law(
        system,
        law,
        sensors,
        sensor_std=sensor_std,
        camera_std=camera_std,
        sample_time=sample_time,
        parameters=settings,
        replaced=Replacements.given(*replaced),
    )
    assert isinstance(found, Designed)
    if report is not None and found.reduced is not None and found.plant is not None:
        from warmlink.controllers.design.plant import plant_model
        from warmlink.orchestration.report.design import write_report

        title, lead = f"{law} for {Path(system).stem}", f"{'; '.join(found.summary().splitlines())}."
        with fresh_file(report) as target:
            write_report(plant_model(found.plant), found.reduced, found.values, title, lead, target)
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
    to: Literal["c", "st", "table"] = "c",
    design: Path | None = None,
    precision: Literal["double", "single"] | None = None,
    duty: list[str] | None = None,
    data: list[Path] | None = None,
    thermometer: str | None = None,
    unit: str | None = None,
    temperature: str | None = None,
    out: Path | None = None,
) -> None:
    """Write a controller's law for a robot's or machine's own controller: C, Structured Text, or a table.

    --to c: C99, a struct, `init` and `step`, without heap, files or variables of its own, and a program that
    tests it. --to st: Structured Text of IEC 61131-3, one function block that a task calls each sample time,
    its constants with names and units, what a restart must keep as RETAIN; the same as PLCopen XML. Both are
    printed from the same statements and compute the same numbers.

    --to table: for a CNC that computes no law: offset, coefficient and position by one temperature, as CSV;
    the closest line; a regression as one formula. How far they are off the law is stated by duty cycle.

    A README beside them says what goes in and comes out, what is needed, and what is not known.

    Examples: `warmlink export observer --design observer.ssv --precision single --out plc`,
    `warmlink export regression --to st`, `warmlink export regression --to table --duty stop_and_go --unit mm`

    Parameters
    ----------
    law : Controller, as `observer`, or a law of your own, as `my_law.py:MyLaw`.
    to : What to write: `c`, `st` or `table`.
    design : Parameter set (SSV) from `warmlink design`. Default: the design that ships.
    precision : Of the arithmetic: double (LREAL) or single (REAL). Default: double.
    duty : With --to table: scenario, by name or file, in which the table is close to the law. Repeatable.
        Default: every one that ships for the cell.
    data : With --to table: log of the machine (CSV, text, Parquet, Excel) in place of --duty, over which the
        table is close to the law; no model of the machine is needed. Repeatable.
    thermometer : With --to table: temperature that it goes by, as `tip_temperature`. Default: the one
        that tells most.
    unit : With --to table: unit of lengths, as `um` or `mm`. Default: um.
    temperature : With --to table: unit of temperatures, as `degC` or `K`. Default: degC.
    out : Folder to write. Default: LAW.
    """
    given = {"duty": duty, "data": data, "thermometer": thermometer, "unit": unit, "temperature": temperature}
    given = {"precision": precision} if to == "table" else given
    for name, value in given.items():
        if value is not None:
            shown = value[0] if isinstance(value, list) else value
            fit = "--to c or --to st" if to == "table" else "--to table"
            raise InputError(f"{argument(name, shown)}: is for {fit}; leave it out with --to {to}")
    if to == "table":
        from warmlink.orchestration.products.cnc import cnc_table

        table = cnc_table(
            law,
            design,
            duties=duty or (),
            data=data or (),
            thermometer=thermometer,
            unit=unit or "um",
            temperature=temperature or "degC",
        )
        folder = out or Path(table.name)
        table.write(folder)
        answer(f"table  {folder / table.name}.csv    {table.summary().partition(': ')[2]}")
        return
    from warmlink.orchestration.products.export import export as export_law

    found = export_law(law, design, to=to, precision=precision or "double")
    folder = out or Path(found.name)
    found.write(folder)
    step = f"{found.core.operations()} operations in a step of {found.core.period:g} s"
    answer(f"law  {folder / next(iter(found.files))}    {step}")
