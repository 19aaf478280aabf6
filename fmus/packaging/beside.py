"""What an FMU carries beside its description and its code, for people and for tools.

Documentation, terminals, and what it can be tried out with, as FMI-LS-REF 1.0.0-alpha.1 has it
(modelica/fmi-ls-ref). A manifest names the files with their roles: the nominal parameters, and a smoke test
with its results. The smoke test is written as that standard's drafts had it before the format moved to
MA-HS-Experiments.
"""

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree as ET

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component, Input, Parameter, Scalar
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.attributes import add, document, typed
from warmlink.fmus.packaging.documentation import documentation_page

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
"""Where FMI-LS-REF has its files, inside an FMU of FMI 2.0 or 3.0."""

STEPS = 5  # of the smoke test
_DIGITS = 7  # fewer than those in which machines may differ

_ABOUT = "Layered Standard providing information on related files included in an FMU."
_STANDARD = {"name": "org.fmi-standard.fmi-ls-ref", "version": "1.0.0-alpha.1", "description": _ABOUT}
_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
for _prefix, _uri in (("fmi-ls", _NAMESPACE), ("ssv", _SSV)):
    ET.register_namespace(_prefix, _uri)


def files_beside(entry: Entry, fmi_version: str = "2.0", arrays: bool = False) -> dict[str, bytes]:
    """Give these files by path inside an FMU, and the picture that tools show on a block.

    With `arrays`, for FMI 3.0, those of FMI-LS-REF are left out: parameter sets know no arrays.
    """
    picture = "model.png" if fmi_version == "2.0" else "terminalsAndIcons/icon.png"
    return {
        "documentation/index.html": documentation_page(entry),
        "documentation/licenses/license.txt": release.license_text().encode("utf-8"),
        picture: Path(__file__).with_name("icon.png").read_bytes(),
        **table_files(entry.component),
        **terminals_files(entry.component, arrays),
        **({} if arrays else reference_files(entry.component, fmi_version)),
    }


def table_files(component: Component) -> dict[str, bytes]:
    """Give the tables that a component plays, by path inside an FMU."""
    return {f"resources/{each.file}": each.content for each in component.tables}


def terminals_files(component: Component, arrays: bool = False) -> dict[str, bytes]:
    """Give terminalsAndIcons.xml by its path inside an FMU; nothing for a component without terminals.

    FMI 2.0 does not know the file, and gets it as FMI 3.0 has it (section 2.4.9 there). Members are signals,
    connected by their names. With `arrays` an array is one member, whose name has no number.
    """
    if not component.terminals:
        return {}
    whole = {s.name: s.variable.name for s in component.scalars() if arrays and s.variable.size is not None}
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = add(root, "Terminals")
    for terminal in component.terminals:
        kind = f"warmlink.{terminal.kind}"
        around = add(terminals, "Terminal", name=terminal.name, matchingRule="bus", terminalKind=kind)
        named = {whole.get(s, s): re.sub(r"_\d+", "", m) if s in whole else m for m, s in terminal.members}
        for name, member in named.items():
            told = {"variableName": name, "memberName": member, "variableKind": "signal"}
            add(around, "TerminalMemberVariable", told)
    return {"terminalsAndIcons/terminalsAndIcons.xml": document(root)}


def reference_files(component: Component, fmi_version: str = "2.0") -> dict[str, bytes]:
    """Give the manifest of FMI-LS-REF and the files that it names, by path inside an FMU."""
    starts = {s: s.start for s in component.scalars() if isinstance(s.variable, Parameter)}
    demands, results, reached = _smoke_test(component)
    step, test = component.default_step_size, ET.Element("Experiments")
    times = {"startTime": 0.0, "stopTime": reached * step, "stepSize": step}
    experiment = add(test, "Experiment", {"name": "smoke-test"}, **times)
    add(experiment, "Parameters", source="smoke-test.ssv")
    add(experiment, "References", source="smoke-test.csv")
    root = ET.Element("fmiReferences", {f"{{{_NAMESPACE}}}fmi-ls-{k}": v for k, v in _STANDARD.items()})
    files: dict[str, bytes] = {}

    def relate(name: str, content: bytes, kind: str, role: str, about: str) -> None:
        files[f"{FOLDER}/{name}"] = content
        add(root, "Related", {"type": kind, "source": name, "role": role, "description": about})

    for name, values, about in (
        ("nominal", starts, "nominal values of all parameters"),
        ("smoke-test", demands, "inputs of the smoke test"),
    ):
        ssv = _parameter_set(name, values, fmi_version)
        relate(f"{name}.ssv", ssv, "application/x-ssp-parameter-set", "parameter", about)
    kind, role = "application/x-ma-ls-experiments", "experiment/smoke-test"
    relate("smoke-test.exp", document(test), kind, role, "smoke test")
    relate("smoke-test.csv", results, "text/csv", "result", f"its results, with {_DIGITS} digits")
    return files | {f"{FOLDER}/fmi-ls-manifest.xml": document(root)}


@lru_cache(maxsize=64)
def _smoke_test(component: Component) -> tuple[Mapping[Scalar, float | None], bytes, int]:
    """Give inputs that move something, as CSV the outputs after each step with them, and how many steps.

    A component that fails with them is built all the same: its smoke test ends before.
    """
    demands = {s: _demand(s.variable) for s in component.scalars() if isinstance(s.variable, Input)}
    instance = Instance(component)
    instance.set({scalar.name: value for scalar, value in demands.items()})
    instance.begin()
    instance.initialize()
    step, lines = component.default_step_size, [",".join(["time", *(f'"{n}"' for n in component.y.names)])]
    for k in range(STEPS + 1):
        lines.append(",".join(f"{value:.{_DIGITS}g}" for value in (k * step, *instance.outputs())))
        if k < STEPS:
            try:
                instance.step(k * step, step)
            except (ArithmeticError, InputError):
                break
    return demands, "\n".join([*lines, ""]).encode(), k


def _demand(variable: Input) -> float:
    """Something else than the start value, of an ordinary size."""
    if variable.type != "Real":
        return variable.start
    moved = variable.start + (5.0 if variable.unit == "K" else variable.nominal or 1.0)
    return moved if variable.maximum is None else min(moved, variable.maximum)


def _parameter_set(name: str, values: Mapping[Scalar, float | None], fmi_version: str) -> bytes:
    """Parameter set (SSP 1.0), each value in its variable's own unit; in FMI 3.0, choices by name."""
    root = ET.Element(f"{{{_SSV}}}ParameterSet", version="1.0", name=name)
    held = add(root, f"{{{_SSV}}}Parameters")
    for scalar, value in values.items():
        parameter, choice = add(held, f"{{{_SSV}}}Parameter", name=scalar.name), scalar.variable.choice
        if choice is not None and fmi_version == "3.0":
            add(parameter, f"{{{_SSV}}}Enumeration", value=choice.items[int(value or 0.0)])
        else:
            given = typed(scalar.variable, value or 0.0)
            add(parameter, f"{{{_SSV}}}{scalar.variable.type}", value=given)
    return document(root)
