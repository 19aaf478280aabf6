"""`warmlink live`: a page in which a scenario runs, to be played with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line import options
from warmlink.orchestration.command_line.options import Parameters, ScenarioName, Set
from warmlink.orchestration.console import answer, remark


def live(
    scenario: ScenarioName = "windshield_wiper",
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="Controller that the page compares. Repeatable. Default: the one that the scenario names, "
            "and `observer`.",
            autocompletion=options.controllers,
        ),
    ] = None,
    set_: Set = None,
    parameters: Parameters = None,
    out: Annotated[Path | None, typer.Option(help="Page to write. Default: SCENARIO.html.")] = None,
) -> None:
    """Write one page in which a scenario runs: drag the duty and the sliders, and see the error at once.

    The page opens from disk in any browser of 2023 or later, without a network and without Python, so that
    you can send it to anybody. It shows the command that computes the same figures.

    Examples: `warmlink live`, `warmlink live my_cell.toml --controller lag --controller observer`

    It needs a compiler for browsers once: `pip install "warmlink[live]"`.
    """
    from warmlink.fmus.errors import InputError
    from warmlink.orchestration.closed_loop.belief import judged
    from warmlink.orchestration.closed_loop.load import load_scenario
    from warmlink.orchestration.closed_loop.run import changed
    from warmlink.orchestration.console import spinner
    from warmlink.orchestration.files import fresh_file
    from warmlink.orchestration.own_law import controller_named
    from warmlink.orchestration.report.live.content import Asked
    from warmlink.orchestration.report.live.page import BESIDE, write_live_page

    if out is not None and out.suffix != ".html":
        raise InputError(f"--out {out}: is no page; name a file that ends in .html")
    sets = options.sets_given(parameters, set_)
    given = {name: value for each in sets for name, value in each.values.items()}
    asked = changed(load_scenario(scenario), parameters=given)
    names = controller or [asked.controller.name, BESIDE]
    laws = [controller_named(name) for name in dict.fromkeys(names)]
    path = out or Path(f"{asked.name}.html")
    with spinner("compiling the system for the browser"), fresh_file(path) as target:
        write_live_page(target, asked, laws, Asked(scenario, given))
    advice, _ = judged(asked)
    if advice is not None:
        remark(advice)
    answer(f"page  {path}    open it in a browser")
