"""A page in which a scenario runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.names import several
from warmlink.fmus.packaging.native.compile import BROWSER, compilers
from warmlink.orchestration.catalogue import controller_named
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import Answer, remark
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.report.live.content import Asked
from warmlink.orchestration.report.live.page import live_page, usual_laws
from warmlink.orchestration.scenarios.overrides import given_values
from warmlink.orchestration.scenarios.scenario import changed


@dataclass(frozen=True, repr=False)
class LivePage(Answer):
    """One page with a system inside that runs in the browser; a notebook shows it."""

    name: str
    html: str

    def summary(self) -> str:
        """What the page is of, and its size."""
        return (
            f"live page of {self.name}, {len(self.html) / 1e6:.1f} MB; write it to a file to open or send it"
        )

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{escape(self.html)}" style="width:100%; height:900px; border:0"></iframe>'

    def write(self, path: str | Path) -> None:
        """Write the page; InputError if it cannot be written."""
        with fresh_file(Path(path)) as target:
            target.write_text(self.html, encoding="utf-8")


def live(
    scenario: str = "windshield_wiper",
    controllers: Sequence[str] | str = (),
    *,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    sets: Sequence[str | Path] = (),
) -> LivePage:
    """Make one page in which a scenario runs: drag the duty and the sliders, and see the error at once.

    Parameters
    ----------
    scenario : a shipped scenario by name, or a file (TOML, CSV)
    controllers : the controllers that the page compares; by default the scenario's, and `observer` where it
        has the start values that are given
    parameters : start values by name, or the path of a parameter set (SSV)
    sets : paths of more parameter sets, which come before; the page's command names the files

    Raises
    ------
    InputError
        If something of a name does not exist, the system contains foreign FMUs, or zig is not installed.

    Examples
    --------
    >>> wl.live("stop_and_go", "observer").write("stop_and_go.html")
    """
    typed = dict(parameters) if isinstance(parameters, Mapping) else {}
    files = [*sets, *(() if isinstance(parameters, Mapping) else (parameters,))]
    given = {name: value for each in files for name, value in given_values(each).items()} | typed
    asked = changed(load_scenario(scenario), parameters=given)
    if not asked.machine.never_joined:  # which is refused where the system is made; that takes a while
        compilers((BROWSER,))
    laws = [controller_named(name) for name in dict.fromkeys(several(controllers))] or usual_laws(asked)
    with spinner("Compiling for the browser") as progress:
        html = live_page(asked, laws, Asked(scenario, typed, parameters=[*map(str, files)]), progress)
    for law in laws:
        advice, _ = design_check(replace(asked, controller=law))
        if advice is not None:
            remark(advice)
    return LivePage(asked.name, html)
