"""The page as one file: its content, its modules, its script."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from importlib import resources

from warmlink.fmus.packaging.cache import kept, kept_before, source_digest
from warmlink.fmus.packaging.native.fmu import browser_module
from warmlink.fmus.safe_text import printable_json
from warmlink.orchestration.catalogue import Controller, shipped
from warmlink.orchestration.progress import Progress, unseen
from warmlink.orchestration.report.figures import LOOKS
from warmlink.orchestration.report.live.content import Asked, WholeSystem, content
from warmlink.orchestration.report.live.form import form, longest
from warmlink.orchestration.report.page import rendered
from warmlink.orchestration.scenarios.overrides import settable
from warmlink.orchestration.scenarios.scenario import Scenario

SCRIPTS = ("engine", "figures", "measured", "model", "controls", "share", "page")
"""The page's modules in an order in which each imports from those before it."""

BESIDE = "observer"
"""Law that the page shows beside the scenario's, unless others are asked for."""

MODULES = "modules"
"""Folder of the compiled systems below the cache."""

_MODULE_LINES = re.compile(r"^(?:import .*\n|export )", re.MULTILINE)


def usual_laws(scenario: Scenario) -> list[Controller]:
    """The scenario's law, and `observer` where the start values that controllers are given are for it too."""
    split = (name.rpartition(".") for name in scenario.parameters)
    given = {name for instance, _, name in split if instance in scenario.machine.controllers}
    laws = {law.name: law for law in (scenario.controller, shipped(BESIDE))}.values()
    return [law for law in laws if law is scenario.controller or given <= settable(law.component).keys()]


def live_page(
    scenario: Scenario, controllers: Sequence[Controller], asked: Asked, progress: Progress = unseen
) -> str:
    """The page of a scenario with some controllers beside each other; `asked` is how it was named.

    Each system is compiled once, without start values, for all scenarios that share it.

    Raises
    ------
    InputError
        If the system contains foreign FMUs, zig is not installed, or a controller refuses a start value.
    """
    systems = []
    for k, law in enumerate(controllers):
        progress(f"system {k + 1} of {len(controllers)}, with {law.name}", k / len(controllers))
        one = replace(scenario, controller=law)
        whole = one.joined({})
        module = kept(MODULES, _made_from(one), partial(browser_module, whole))
        systems.append(WholeSystem(one, whole, module))
    return _page(systems, asked)


def kept_live_page(scenario: Scenario, asked: Asked) -> str:
    """The page of a scenario whose system `live_page` has compiled before; empty where it has not.

    Of the laws that `warmlink live` shows, those are on it whose systems are compiled.
    """
    systems = []
    for one in (replace(scenario, controller=law) for law in usual_laws(scenario)):
        module = None if scenario.machine.never_joined else kept_before(MODULES, _made_from(one))
        if module is not None:
            systems.append(WholeSystem(one, one.joined({}), module))
        elif not systems:
            return ""
    return _page(systems, asked)


def _page(systems: Sequence[WholeSystem], asked: Asked) -> str:
    scenario, whole, _ = systems[0]
    known = content(systems, asked)
    folder = resources.files("warmlink.orchestration.report.live")
    texts = [(folder / f"{name}.js").read_text("utf-8") for name in SCRIPTS]
    return rendered(
        "live/live.html.j2",
        title=scenario.title,
        kind="live",
        lead="The cell is computed …",
        known=known,
        looks=LOOKS,
        content=printable_json(json.dumps(known, allow_nan=False)).replace("<", "\\u003c"),
        modules={one.scenario.controller.name: packed(one.module) for one in systems},
        tables=[packed(each.until(longest(scenario)).content) for each in whole.tables],
        # As one script, without what the modules import from each other.
        script="\n".join(_MODULE_LINES.sub("", text) for text in texts),
        **form(scenario, whole),
    )


def _made_from(scenario: Scenario) -> tuple[object, ...]:
    """What the module of a system is made from; the scenario's start values are set when it runs."""
    return source_digest(), *scenario.made_from


def packed(content: bytes) -> str:
    """Bytes as text that the page unpacks."""
    return base64.b64encode(zlib.compress(content, 9)).decode()
