"""`warmlink watch`: the twin beside a running machine."""

from __future__ import annotations

import json as as_json
from pathlib import Path
from typing import Any

from warmlink.fmus.safe_text import printable
from warmlink.orchestration.command_line.arguments import settings_given
from warmlink.orchestration.console import answer, remark

COMMANDS = ("watch",)


def watch(
    source: str,
    *,
    sound: str = "24 h",
    alarms: str = "1 per 30 days",
    tick: str = "60 s",
    controller: str | None = None,
    parameters: Path | None = None,
    system: str | None = None,
    scenario: str | None = None,
    set_: list[str] | None = None,
    unit: list[str] | None = None,
    map_: list[str] | None = None,
    decimal: str = "",
    mapping: Path | None = None,
    until_end: bool = False,
    speed: float = 0.0,
    serve: str = "",
    diagnose: bool = False,
    out: Path = Path("out/watch"),
    json: bool = False,
) -> None:
    """Watch a running machine: say when its model, a thermometer or a clock no longer fits, and why.

    The model runs beside the machine as a filter. The opening part of the log, which you declare sound,
    calibrates it and tells how large its errors are; then both are frozen. An alarm comes when the readings
    lean one way for longer than they do in so many sound days by chance. Writes alarms.jsonl, watch.html, a
    page that renews itself, and watch.state, from which the same command goes on after a restart. Nothing is
    ever written to the machine. Ctrl-C ends it.

    Examples: `warmlink watch cell.csv --sound "7 days"`, `tail -F cell.csv | warmlink watch -`

    Parameters
    ----------
    source : A log that grows (CSV), - for standard input, mqtt://HOST/TOPIC (JSON, a row in each message), or
        opc.tcp://HOST:PORT.
    sound : How long the opening part lasts that you declare sound. The longer it is and the more of your
        work it holds, the less evidence an alarm needs.
    alarms : How often a false alarm is bearable.
    tick : How much of the log is judged at once; less for a small machine that warms within minutes.
    controller : A law that runs in shadow and is judged by the growth that it would leave. Default: the log's
        column `correction` is judged, if it has one.
    parameters : Parameter set (SSV) of that law.
    system : Your machine: a shipped one by its name, as BenchMotor, or an SSP. Default: the warm-up cell.
    scenario : Scenario file (TOML) of your machine, with its [parameters], instead of --system.
    set_ : Parameter of your machine that differs from the nominal one, for example --set "link.length=800
        mm". Repeatable.
    unit : Unit that is missing from a header: --unit "T_base=degC". Repeatable.
    map_ : Which variable a column holds, for example --map "T_base=base_temperature". Repeatable.
    decimal : Decimal mark, `comma` or `point`, if the file could be read either way.
    mapping : TOML file whose [columns] say which value of a server stands under which header, for example
        "shaft_temperature [degC]" = "Motor_1/MotorTemperature".
    until_end : End where the log ends, rather than wait for more; a server's ends after 5 s of silence.
    speed : Replay the log so many times faster than it was recorded, for example --speed 60. Default: as
        fast as it comes.
    serve : Serve the page, read only, at HOST:PORT, for example --serve 127.0.0.1:8080.
    diagnose : Diagnose each alarm meanwhile, in a process of its own that makes way for others: for minutes,
        for half an hour at most. With --until-end it is waited for.
    out : Folder for the files.
    json : Print events as JSON, one object a line, for other programs.
    """
    from warmlink.orchestration.products.watch import MachineSettings, WatchSettings, watching

    told: dict[str, Any] = {"units": unit or [], "names": map_ or [], "decimal": decimal}
    judged = WatchSettings(sound, alarms, tick, controller, parameters)
    with watching(
        source,
        out,
        told,
        judged,
        MachineSettings(system, scenario, settings_given(set_)),
        until_end=until_end,
        speed=speed,
        serve=serve,
        mapping=mapping,
        diagnose=diagnose,
    ) as work:
        try:
            for event in work.run():
                if json:
                    print(as_json.dumps(event), flush=True)
                else:
                    answer(_in_words(event))
        except KeyboardInterrupt:
            remark(f"ended; {work.rows} rows were read, and the same command goes on from here")
        for each in work.remarks():
            remark(each)
    count = len(work.alarms)
    if not json:
        answer(f"{count} alarm{'s' * (count != 1)} in {work.rows} rows    page  {out / 'watch.html'}")


def _in_words(event: dict[str, Any]) -> str:
    """An event as a line."""
    from warmlink.orchestration.watch.page import when

    at = f"{when(event['time_s'])}  " if "time_s" in event else ""
    kind = (
        f"{'the same alarm' if 'again' in event else 'ALARM'} ({event['verdict']}): "
        if event["alarm"]
        else ""
    )
    return printable(f"{at}{kind}{event['told']}")
