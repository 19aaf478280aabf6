"""The WebAssembly module of a system with a controller, compiled once."""

from __future__ import annotations

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.cache import kept, source_digest
from warmlink.fmus.packaging.native.browser import browser_module
from warmlink.orchestration.scenarios.scenario import Scenario


def module(scenario: Scenario, whole: Component) -> bytes:
    """The module of a scenario's system.

    Parameters
    ----------
    scenario : says of which parts and wires the system is made
    whole : its system as one component with the start values that the parts declare, `scenario.joined({})`:
        those of the scenario are set when it runs, so that all scenarios of a system share a module

    Raises
    ------
    InputError
        If zig is not installed.
    """
    return kept("modules", (source_digest(), *scenario.made_from), lambda: browser_module(whole))
