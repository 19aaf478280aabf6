"""The page as one file: its content, its modules, its script."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.cache import kept, kept_before, source_digest
from warmlink.fmus.packaging.native.fmu import browser_module
from warmlink.orchestration.catalogue import Controller, shipped
from warmlink.orchestration.report.live.content import Asked, Whole, content
from warmlink.orchestration.report.page import rendered
from warmlink.orchestration.scenarios.scenario import Scenario

SCRIPTS = ("engine", "figures", "dom", "plot", "model", "sliders", "duty", "measured", "share", "page")
"""The page's modules in an order in which each imports from those before it."""

BESIDE = "observer"
"""Law that the page shows beside the scenario's, unless others are asked for."""

MODULES = "modules"
"""Folder of the compiled systems below the cache."""

TRUST = (
    "The system is integrated in one piece, compiled from the C code of its FMUs: the numbers are those of "
    "the native FMU of the whole system. The command couples one FMU for each part, so that its numbers "
    "differ by the coupling error that it states."
)

_MODULE_LINES = re.compile(r"^(?:import .*\n|export )", re.MULTILINE)


def write_live_page(path: Path, scenario: Scenario, controllers: Sequence[Controller], asked: Asked) -> None:
    """Write the page of a scenario with some controllers beside each other; `asked` is how it was named.

    Raises
    ------
    InputError
        If the system contains foreign FMUs, zig is not installed, or a controller refuses a start value.
    """
    each = [replace(scenario, controller=law) for law in controllers]
    systems = [Whole(one, one.joined({})) for one in each]
    path.write_text(_page(systems, [_module(*one) for one in systems], asked), encoding="utf-8")


def kept_live_page(scenario: Scenario, asked: Asked) -> str:
    """The page of a scenario whose system `write_live_page` has compiled before; empty where it has not.

    The law beside the scenario's is the one that `warmlink live` adds, where it is compiled too.
    """
    if scenario.setup.foreign:
        return ""
    laws = {law.name: law for law in (scenario.controller, shipped(BESIDE))}
    each = [replace(scenario, controller=law) for law in laws.values()]
    found = [(one, module) for one in each if (module := kept_before(MODULES, _made_from(one))) is not None]
    if not found or found[0][0].controller.name != scenario.controller.name:
        return ""
    systems = [Whole(one, one.joined({})) for one, _ in found]
    return _page(systems, [module for _, module in found], asked)


def _page(systems: Sequence[Whole], modules: Sequence[bytes], asked: Asked) -> str:
    scenario, _ = systems[0]
    known = content(systems, asked)
    laws = [one.scenario.controller.name for one in systems]
    return rendered(
        "live/live.html.j2",
        title=scenario.title,
        plots=known["plots"],
        trust=TRUST,
        content=json.dumps(known, allow_nan=False).replace("<", "\\u003c"),
        modules={law: _packed(module) for law, module in zip(laws, modules, strict=True)},
        script=script(),
    )


def _module(scenario: Scenario, whole: Component) -> bytes:
    """The WebAssembly module of a scenario's system, compiled once for all scenarios that share the system.

    `whole` is the system as one component with the start values that the parts declare; those of the scenario
    are set when it runs.
    """
    return kept(MODULES, _made_from(scenario), lambda: browser_module(whole))


def _made_from(scenario: Scenario) -> tuple[object, ...]:
    return source_digest(), *scenario.made_from


def script() -> str:
    """The modules as one script, without what they import from each other."""
    folder = resources.files("warmlink.orchestration.report.live")
    texts = [(folder / f"{name}.js").read_text("utf-8") for name in SCRIPTS]
    return "\n".join(_MODULE_LINES.sub("", text) for text in texts)


def _packed(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()
