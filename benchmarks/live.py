"""How soon the page of `warmlink live` follows a slider, in each browser that is installed."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
import typer
from rich.console import Console
from rich.table import Table

import warmlink as wl
from benchmarks.command import start
from tests.browser import Browser
from tests.chromium import Chromium
from tests.firefox import Firefox

PAGES = {"warm_up": "", "six_axis_shift": "axis2."}
"""Scenarios, and what the name of their link begins with."""

SCRIPT = """
    while (!document.querySelector(".slider:not([hidden])")) await new Promise((go) => setTimeout(go, 50));
    const name = "{axis}link.length";
    const {{ value }} = fields(name)[0];
    const drawn = () => new Promise((go) => setTimeout(go));
    async function redrawn(before) {{
      const times = [];
      for (let i = 1; i <= {rounds}; i++) {{
        before();
        await drawn();
        const begun = performance.now();
        put({{ [name]: `${{value * (1 + i / 1000)}}` }});
        await drawn();
        times.push(performance.now() - begun);
      }}
      return times.sort((a, b) => a - b)[Math.floor(times.length / 2)];
    }}
    const searched = () => new Uint8Array(1000).indexOf(1);
    const result = {{ plain: await redrawn(() => {{}}), after: await redrawn(searched) }};
    if (document.getElementById("fault").textContent) throw new Error("a redraw was refused");
"""


@dataclass(frozen=True)
class Redraw:
    """Medians of the time from a slider's move to the drawn page [ms].

    `after` a search, which in Firefox 140 slows WebAssembly on some processors.
    """

    plain: float
    after: float


def redraw(kind: type[Browser], page: Path, axis: str, rounds: int) -> Redraw:
    """Move the length of an axis's link on a page in a browser."""
    with (
        # A browser that was killed may still write for a moment.
        tempfile.TemporaryDirectory(prefix="warmlink-", ignore_cleanup_errors=True) as folder,
        kind.started(Path(folder)) as browser,
    ):
        script = SCRIPT.format(axis=axis, rounds=rounds)
        return Redraw(**browser.browse(page, script))


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Moves of the slider whose median is taken.")] = 15,
) -> None:
    """Make a page of the warm-up cell and one of a shift of the six-axis arm, and move a slider in them."""
    table = Table("scenario", "browser", "redrawn, ms", "after a search, ms", box=None)
    with tempfile.TemporaryDirectory(prefix="warmlink-") as folder:
        for scenario, axis in PAGES.items():
            page = Path(folder) / f"{scenario}.html"
            wl.live(scenario, ["lag"]).write(page)
            for kind in (Chromium, Firefox):
                try:
                    found = redraw(kind, page, axis, rounds)
                except pytest.skip.Exception as absent:
                    table.add_row(scenario, kind.__name__, str(absent), "")
                    continue
                table.add_row(scenario, kind.__name__, f"{found.plain:.0f}", f"{found.after:.0f}")
    Console().print(table)


if __name__ == "__main__":
    start(main)
