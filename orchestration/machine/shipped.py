"""The machines that warmlink ships: one file each in `library/`.

A file says what `Machine` holds; of wires it gives the output behind each input. Instead, `made_by` may name
a function without arguments that returns the machine, as `package.module:function`.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.plugins import plugins
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.machine.roles import NOTHING_SCORED, Roles
from warmlink.orchestration.system.ports import Ports
from warmlink.orchestration.written.expression import Expression

LIBRARY = Path(__file__).parent / "library"


def machines() -> dict[str, str]:
    """One line about each shipped machine by its name."""
    found = {name: str(_content(path)["about"]) for name, path in _files().items()}
    return found | {name: made.about for name, made in _added().items() if name not in found}


def machine_named(name: str) -> Machine:
    """A shipped machine by its name; InputError if there is none of that name."""
    files = _files()
    if name in files:
        return _machine(files[name])
    if name not in _added():
        raise InputError(f"{name}: no such machine; {instead(name, machines())}")
    return _added()[name]


@cache
def _machine(path: Path) -> Machine:
    content = dict(_content(path))
    if maker := content.pop("made_by", None):
        made: Machine = EntryPoint("", str(maker), "").load()()
        return made
    content["wires"] = tuple((source, target) for target, source in content.get("wires", {}).items())
    content["signals"] = {name: tuple(ends) for name, ends in content.get("signals", {}).items()}
    content["roles"] = _roles(content["roles"]) if "roles" in content else NOTHING_SCORED
    plots = content.get("plots", [])
    content["plots"] = {(each["heading"], each["unit"]): each["lines"] for each in plots}
    if ports := content.get("ports"):
        shown = (end.rpartition(".") for end in ports["shown"])
        content["ports"] = Ports(tuple(ports["drivers"]), tuple((part, each) for part, _, each in shown))
    return Machine(path.stem, **content)


def _roles(table: dict[str, str]) -> Roles:
    without = Expression(table["uncompensated"], "uncompensated")
    return Roles(Expression(table["score"]), without, without.variables)


@cache
def _added() -> dict[str, Machine]:
    """Machines that other packages add."""
    return {each.name: each.load() for each in plugins("machines")}


def _files() -> dict[str, Path]:
    return {path.stem: path for path in sorted(LIBRARY.glob("*.toml"))}


@cache
def _content(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text("utf-8"))


WARMUP_CELL = machine_named(DEFAULT)
"""The machine of a scenario that names none: one motor, one link."""
