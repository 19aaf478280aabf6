"""`warmlink live`, `plot` and `reproduce`: pages that a person looks at."""

from __future__ import annotations

from pathlib import Path

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line.arguments import values_given
from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.files import fresh_file, locked_folder
from warmlink.orchestration.results import refuse_others, results_folder

COMMANDS = ("live", "plot", "reproduce")

PICTURES = (".svg", ".png", ".pdf")


def live(
    scenario: str = "windshield_wiper",
    *,
    controller: list[str] | None = None,
    set_: list[str] | None = None,
    parameters: list[Path] | None = None,
    out: Path | None = None,
) -> None:
    """Write one page in which a scenario runs: drag the duty and the sliders, and see the error at once.

    The page opens from disk in any browser of 2024 or later, without a network and without Python, so that
    you can send it to anybody. It shows the command that computes the same figures.

    Examples: `warmlink live`, `warmlink live my_cell.toml --controller lag --controller observer`

    It needs a compiler for browsers once: `pip install "warmlink[live]"`.

    Parameters
    ----------
    controller : Controller that the page compares. Repeatable. Default: the one that the scenario names, and
        `observer` where it has the start values that are given.
    out : Page to write. Default: SCENARIO.html.
    """
    from warmlink.orchestration.products.live import live as live_page

    if out is not None and out.suffix != ".html":
        raise InputError(f"--out {out}: is no page; name a file that ends in .html")
    page = live_page(scenario, controller or (), parameters=values_given(None, set_), sets=parameters or ())
    path = out or Path(f"{page.name}.html")
    page.write(path)
    answer(f"page  {path}    open it in a browser")


def plot(
    results: Path,
    variables: list[str] | None = None,
    *,
    against: Path | None = None,
    out: Path = Path("plot.html"),
) -> None:
    """Draw variables of a run over time, or of two runs beside each other.

    Example: `warmlink plot out/windshield_wiper link.elongation compensator.correction --out growth.svg`

    Parameters
    ----------
    results : Folder with results of `run` or `simulate`, or the CSV or Parquet file.
    variables : Variables of one unit, as `link.elongation`. Default: the error of the tool point.
    against : Other results, whose variables are drawn beside them.
    out : Page (.html) or picture (.svg, .png, .pdf) to write.
    """
    from warmlink.orchestration.report.page import Section, write_page
    from warmlink.orchestration.report.plot import picture
    from warmlink.orchestration.report.plot import plot as plot_variables

    if out.suffix not in (".html", *PICTURES):
        raise InputError(f"--out {out}: is no page or picture; name a file that ends in .html or .svg")
    figure = plot_variables(results, *(variables or ()), against=against)
    with fresh_file(out) as target:
        if out.suffix in PICTURES:
            picture(figure, target, out.suffix[1:])
        else:
            write_page(
                target,
                ", ".join(variables or ["error"]),
                f"Results in {results}.",
                [Section("", figure=figure)],
            )
    answer(str(out))


def reproduce(*, out: Path = Path("out/reproduce"), json: bool = False) -> None:
    """Compute every table and figure of the paper by Eq. (4), by the 1-D link and by 3-D finite elements.

    Parameters
    ----------
    out : Folder for the report.
    """
    from rich.console import Console

    from warmlink.orchestration.paper.presentation import terminal, write_report
    from warmlink.orchestration.paper.reproduce import reproduce as reproduce_paper

    refuse_others(out, "reproduce")
    with locked_folder(out), results_folder(out, "reproduce") as target:
        result = reproduce_paper()
        write_report(result, target / "report.html")
    if json:
        answer_json(result.to_dict())
    else:
        Console().print(terminal(result))
        answer(f"report  {out / 'report.html'}")
