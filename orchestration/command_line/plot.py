"""`warmlink plot`: variables of a run over time, as a page or a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.options import Argument, Option
from warmlink.orchestration.console import answer

PICTURES = (".svg", ".png", ".pdf")


def plot(
    results: Annotated[
        Path,
        Argument(help="Folder with results of `run` or `simulate`, or the CSV or Parquet file."),
    ],
    variables: Annotated[list[str], Argument(help="Variables of one unit, as `link.elongation`.")],
    against: Annotated[
        Path | None, Option(help="Other results, whose variables are drawn beside them.")
    ] = None,
    out: Annotated[Path, Option(help="Page (.html) or picture (.svg, .png, .pdf) to write.")] = Path(
        "plot.html"
    ),
) -> None:
    """Draw variables of a run over time, or of two runs beside each other.

    Example: `warmlink plot out/windshield_wiper link.elongation compensator.correction --out growth.svg`
    """
    from warmlink.orchestration.files import fresh_file
    from warmlink.orchestration.report.page import Section, write_page
    from warmlink.orchestration.report.plot import picture
    from warmlink.orchestration.report.plot import plot as plot_variables

    if out.suffix not in (".html", *PICTURES):
        raise InputError(f"--out {out}: is no page or picture; name a file that ends in .html or .svg")
    figure = plot_variables(results, *variables, against=against)
    with fresh_file(out) as target:
        if out.suffix in PICTURES:
            picture(figure, target, out.suffix[1:])
        else:
            write_page(target, ", ".join(variables), f"Results in {results}.", [Section("", figure=figure)])
    answer(str(out))
