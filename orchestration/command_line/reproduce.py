"""`warmlink reproduce`: the paper's tables beside ours."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from warmlink.orchestration.command_line.options import Json
from warmlink.orchestration.console import answer, answer_json, progress_bar


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("out/reproduce"),
    json: Json = False,
) -> None:
    """Compute every table and figure of the paper by Eq. (4), by the 1-D link and by 3-D finite elements."""
    from rich.console import Console

    from warmlink.orchestration.files import fresh_folder
    from warmlink.orchestration.paper.presentation import terminal, write_report
    from warmlink.orchestration.paper.reproduce import reproduce as reproduce_paper

    with fresh_folder(out) as target:
        with progress_bar("The paper, reproduced") as progress:
            result = reproduce_paper(progress)
        write_report(result, target / "report.html")
    if json:
        answer_json({"rows": [asdict(row) for row in result.rows], "findings": list(result.findings)})
    else:
        Console().print(terminal(result))
        answer(f"report  {out / 'report.html'}")
