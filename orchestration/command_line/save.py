"""`warmlink save`: a scenario's system as a file for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line import options
from warmlink.orchestration.command_line.options import Fmus, Parameters, Set
from warmlink.orchestration.console import answer, remark


def save(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario (TOML) of your own, or a shipped one by name.", autocompletion=options.scenarios
        ),
    ],
    controller: Annotated[
        str | None,
        typer.Option(help="Controller. Default: the scenario's.", autocompletion=options.controllers),
    ] = None,
    fmus: Fmus = None,
    set_: Set = None,
    parameters: Parameters = None,
    out: Annotated[Path | None, typer.Option(help="SSP to write. Default: SCENARIO.ssp.")] = None,
) -> None:
    """Write a scenario's system, with its duty cycle and controller, as an SSP with its parameter sets (SSV).

    Example: `warmlink save my_cell.toml --parameters observer.ssv --out my_cell.ssp`
    """
    from warmlink.orchestration.closed_loop.belief import judged
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.closed_loop.run import changed
    from warmlink.orchestration.fmu_store import kind_named, store
    from warmlink.orchestration.system.write import write_ssp

    if out is not None and out.suffix != ".ssp":
        raise InputError(f"--out {out}: is no system; name a file that ends in .ssp")
    sets = options.sets_given(parameters, set_)
    given = {name: value for each in sets for name, value in each.values.items()}
    asked = changed(load_scenario(scenario), controller=controller, parameters=given)
    path = out or Path(f"{asked.name}.ssp")
    built = store(kind_named(fmus), sorted(asked.kinds), remark)
    write_ssp(asked.system(asked.files(built)), path)
    advice, _ = judged(asked)
    if advice is not None:
        remark(advice)
    answer(f"system  {path}    run it: warmlink simulate {path}")
