"""What can be set and read of a component, a controller, a system, an FMU or an SSP."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, field, fields, replace
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.component import Component
from warmlink.fmus.component.variables import Input, Local, Output, Parameter
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.documentation import facts
from warmlink.orchestration.console import Answer, table_text
from warmlink.orchestration.system.archive import open_archive
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, FmuVariable, ModelInfo, System

if TYPE_CHECKING:
    import pandas

ROLES = "input", "parameter", "output"

_CAPABILITIES = {
    "variable_step": "steps of any length",
    "get_set_state": "get and set its state",
    "serialize_state": "store its state",
    "directional_derivatives": "give directional derivatives",
    "interpolate_inputs": "take input derivatives",
    "intermediate_update": "take inputs within a step",
    "event_mode": "handle events between steps",
}

SHOWN = ("input", "parameter", "structuralParameter", "output")
"""Causalities of an FMU's variables that concern its user."""

_ELEMENT = re.compile(r"\[(\d+)\]$")


@dataclass(frozen=True)
class VariableRow:
    """One variable as a user sees it; a text is empty where there is nothing to say.

    Attributes
    ----------
    role : input, parameter or output; of a connected input the output that feeds it
    name : as `link.conductivity`; `reading[1..8]` for elements that are declared alike
    unit : of default and range; for what is not a real number its type
    default : the start value
    range : least and largest value
    meaning : what it stands for
    """

    role: str
    name: str
    unit: str
    default: str
    range: str
    meaning: str


HEADINGS = tuple(each.name for each in fields(VariableRow))


@dataclass(frozen=True, repr=False)
class Description(Answer):
    """What something takes and gives; `facts` tell what kind of file it is, by what they are about."""

    name: str
    about: str
    variables: tuple[VariableRow, ...]
    facts: Mapping[str, str] = field(default_factory=dict)

    def summary(self) -> str:
        """A table of the variables."""
        return table_text(f"{self.name}: {self.about}", HEADINGS, map(astuple, self.variables))

    def to_frame(self) -> pandas.DataFrame:
        """A row for each variable."""
        import pandas

        return pandas.DataFrame([asdict(each) for each in self.variables])

    def to_dict(self) -> dict[str, object]:
        """The same for JSON."""
        return asdict(self)


def describe(what: str | Path, *, variant: str | None = None) -> Description:
    """Say what can be set and read of a component, a controller, a system, an FMU or an SSP.

    Parameters
    ----------
    what : a component, controller or system that `warmlink list` shows, as `ThermalLink`; a law of one's
        own, as `my_law.py:MyLaw`; or an .fmu or .ssp file from any tool

    variant : which system, of several in one SSP, by default `SystemStructure`

    Raises
    ------
    InputError
        If there is no such thing or variant, or the file cannot be read.

    Examples
    --------
    >>> print(wl.describe("ThermalLink"))
    >>> wl.describe("WarmupCell").to_frame()
    """
    path = path_given("what", what)
    if path.suffix == ".ssp":
        return _of_system(path, variant)
    if variant is not None:
        told = f"{path.name} has no variants, being no SSP; leave the variant out"
        raise InputError(f"{argument('variant', variant)}: {told}")
    if path.suffix == ".fmu":
        info = read_description(path)
        rows = [_row(each, each.name, each.causality, each.start) for each in info.variables.values()]
        about = info.description or info.model_name
        return Description(path.name, about, _merged(rows), _facts_of_fmu(info, rows))
    found = _component_named(str(what))
    return Description(str(what), found.description, tuple(_of_component(found)))


def _component_named(name: str) -> Component:
    """A component, a controller, also one of the user's own, or a system joined with the controller none."""
    from warmlink.orchestration.catalogue import components, controller, controller_named, controllers
    from warmlink.orchestration.machine.shipped import machine_named, machines

    if ":" in name:
        return controller_named(name).component
    known = {**components(), **controllers()}
    if name in machines():
        return machine_named(name).joined(controller("none"))
    if name not in known:
        remedy = instead(name, [*known, *machines()], "or an .fmu or .ssp file")
        raise InputError(f"{name}: no such component, controller or system; {remedy}")
    return known[name]


def _of_component(component: Component) -> Iterator[VariableRow]:
    outputs = [each for each in component.outputs if not isinstance(each, Local)]
    kinds: dict[str, Sequence[Input | Parameter | Output]] = {
        "input": component.inputs,
        "parameter": component.parameters,
        "output": outputs,
    }
    for role, variables in kinds.items():
        for each in variables:
            yield VariableRow(role, *facts(each))


def _of_system(path: Path, variant: str | None) -> Description:
    from warmlink.orchestration.files import temporary_folder
    from warmlink.orchestration.system.assemble import read_system, variants

    with temporary_folder() as work:
        system = read_system(path, work, variant)
        rows = [row for name in system.components for row in _of_instance(system, name)]
        parts = {
            f"component {name}": f"{info.model_name}, FMI {info.fmi_version}, {_platforms(info.path)}"
            for name, held in system.components.items()
            for info in [read_description(held.fmu)]
        }
    named = variants(path)
    about = {"variants": ", ".join(named)} if len(named) > 1 else {}
    found = {
        **about,
        "connections": str(len(system.connections)),
        **_experiment(system.default_experiment),
        **parts,
    }
    return Description(path.name, system.summary(), _merged(rows), found)


def _facts_of_fmu(info: ModelInfo, rows: Sequence[VariableRow]) -> dict[str, str]:
    """What an integrator asks of an FMU first."""
    can = [words for flag, words in _CAPABILITIES.items() if getattr(info.capabilities, flag)]
    return {
        "model": info.model_name,
        "FMI": f"{info.fmi_version}, {_interfaces(info)}",
        "platforms": _platforms(info.path),
        "can": ", ".join(can) or "nothing beyond fixed steps",
        **_experiment(info.default_experiment),
        **{
            f"{role}s": str(sum(row.role == role for row in rows))
            for role in ("input", "parameter", "output")
        },
    }


def _interfaces(info: ModelInfo) -> str:
    """What an FMU may be used as, that which a system uses by default first."""
    words = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange"}
    first = words.get(info.interface, "scheduled execution")
    return f"{first} and model exchange" if info.exchange else first


def _experiment(proposed: DefaultExperiment) -> dict[str, str]:
    """Times that a file proposes."""
    times = {"stop time": proposed.stop_time, "step size": proposed.step_size}
    return {f"proposed {name}": f"{value:g} s" for name, value in times.items() if value is not None}


def _platforms(fmu: Path) -> str:
    """Platforms for which an FMU holds libraries, as its folders are called."""
    with open_archive(fmu) as archive:
        folders = {PurePosixPath(name).parts[:2] for name in archive.namelist()}
    found = sorted(each[1] for each in folders if len(each) == 2 and each[0] == "binaries")
    return ", ".join(found) or "no libraries"


def _of_instance(system: System, name: str) -> Iterator[VariableRow]:
    """Variables of one instance, with the start values that the system gives it."""
    held = system.components[name]
    fed = {link.target: f"fed by {link.source}" for link in system.connections}
    for each in read_description(held.fmu).variables.values():
        whole = f"{name}.{each.name}"
        yield _row(each, whole, fed.get(whole, each.causality), held.values.get(each.name, each.start))


def _row(variable: FmuVariable, name: str, role: str, start: object) -> VariableRow:
    unit = "" if variable.unit == "1" else variable.unit or ""
    computed = variable.causality not in SHOWN or variable.causality == "output"
    default = "" if start is None or computed else f"{start:.10g}" if isinstance(start, float) else str(start)
    limits = (("≥", variable.min), ("≤", variable.max))
    bounds = ", ".join(f"{sign} {limit:.10g}" for sign, limit in limits if limit is not None)
    return VariableRow(
        role, name, unit if variable.kind == "Real" else variable.type, default, bounds, variable.description
    )


def _merged(rows: Iterable[VariableRow]) -> tuple[VariableRow, ...]:
    """Leave out what shows the inside of an FMU, and write elements that are declared alike in one row."""
    shown = [each for each in rows if each.role in SHOWN or each.role.startswith("fed by ")]
    alike = groupby(shown, lambda row: replace(row, name=_ELEMENT.sub("[]", row.name)))
    return tuple(_as_one(list(group)) for _, group in alike)


def _as_one(rows: list[VariableRow]) -> VariableRow:
    """The row of elements that are declared alike, as `reading[1..8]`."""
    first, last = (_ELEMENT.search(rows[i].name) for i in (0, -1))
    if first is None or last is None or len(rows) == 1:
        return rows[0]
    return replace(rows[0], name=f"{_ELEMENT.sub('', rows[0].name)}[{first[1]}..{last[1]}]")
