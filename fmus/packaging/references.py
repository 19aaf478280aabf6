"""What an FMU carries to be tried out with, as FMI-LS-REF 1.0.0-alpha.1 has it (modelica/fmi-ls-ref).

A manifest names the files with their roles: the nominal parameters, and a smoke test with its results.
The smoke test is written as that standard's drafts had it before the format moved to MA-HS-Experiments.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component, Input, Parameter, Scalar
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.attributes import document, text, typed

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
"""Where the standard has its files, inside an FMU of FMI 2.0 or 3.0."""

STEPS = 5
"""Communication steps of the smoke test."""

_DIGITS = 7  # fewer than those in which machines may differ

_STANDARD = {
    "name": "org.fmi-standard.fmi-ls-ref",
    "version": "1.0.0-alpha.1",
    "description": "Layered Standard providing information on related files included in an FMU.",
}
_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
for _prefix, _uri in (("fmi-ls", _NAMESPACE), ("ssv", _SSV)):
    ET.register_namespace(_prefix, _uri)


def reference_files(component: Component, fmi_version: str = "2.0") -> dict[str, bytes]:
    """Give the manifest of FMI-LS-REF and the files that it names, by path inside an FMU."""
    choices = fmi_version == "3.0"
    starts = {s: s.start for s in component.scalars() if isinstance(s.variable, Parameter)}
    demands, results, reached = _smoke_test(component)
    related = {
        "nominal.ssv": ("parameter", "application/x-ssp-parameter-set", "nominal values of all parameters"),
        "smoke-test.ssv": ("parameter", "application/x-ssp-parameter-set", "inputs of the smoke test"),
        "smoke-test.exp": ("experiment/smoke-test", "application/x-ma-ls-experiments", "smoke test"),
        "smoke-test.csv": ("result", "text/csv", f"its results, with {_DIGITS} digits"),
    }
    contents = (
        _parameters("nominal", starts, choices),
        _parameters("smoke-test", demands, choices),
        _experiment(component, reached),
        results,
    )
    files = dict(zip(related, contents, strict=True))
    root = ET.Element("fmiReferences", {f"{{{_NAMESPACE}}}fmi-ls-{k}": v for k, v in _STANDARD.items()})
    for name, (role, kind, about) in related.items():
        ET.SubElement(root, "Related", type=kind, source=name, role=role, description=about)
    files["fmi-ls-manifest.xml"] = document(root)
    return {f"{FOLDER}/{name}": content for name, content in files.items()}


@lru_cache(maxsize=64)
def _smoke_test(component: Component) -> tuple[Mapping[Scalar, float | None], bytes, int]:
    """Give inputs that move something, as CSV the outputs after each step with them, and how many steps.

    A component that fails with them is built all the same: its smoke test ends before.
    """
    demands = {s: _demand(s) for s in component.scalars() if isinstance(s.variable, Input)}
    instance = Instance(component)
    instance.set({scalar.name: value for scalar, value in demands.items()})
    instance.begin()
    instance.initialize()
    step, names = component.default_step_size, component.y.names
    lines = [",".join(["time", *(f'"{name}"' for name in names)])]
    for k in range(STEPS + 1):
        values = [k * step, *(float(instance.get(name)) for name in names)]
        lines.append(",".join(f"{value:.{_DIGITS}g}" for value in values))
        if k < STEPS:
            try:
                instance.step(k * step, step)
            except (ArithmeticError, InputError):
                break
    return demands, "\n".join([*lines, ""]).encode(), k


def _demand(scalar: Scalar) -> float:
    """Something else than the start value, of an ordinary size."""
    variable = scalar.variable
    assert isinstance(variable, Input)
    if variable.type != "Real":
        return variable.start
    moved = variable.start + (5.0 if variable.unit == "K" else variable.nominal or 1.0)
    return moved if variable.maximum is None else min(moved, variable.maximum)


def _experiment(component: Component, steps: int) -> bytes:
    step = component.default_step_size
    root = ET.Element("Experiments")
    times = {"startTime": "0.0", "stopTime": repr(steps * step), "stepSize": repr(step)}
    experiment = ET.SubElement(root, "Experiment", {"name": "smoke-test"} | times)
    ET.SubElement(experiment, "Parameters", source="smoke-test.ssv")
    ET.SubElement(experiment, "References", source="smoke-test.csv")
    return document(root)


def _parameters(name: str, values: Mapping[Scalar, float | None], choices: bool) -> bytes:
    """Parameter set (SSP 1.0), each value in its variable's own unit; `choices` by name."""
    root = ET.Element(f"{{{_SSV}}}ParameterSet", version="1.0", name=name)
    held = ET.SubElement(root, f"{{{_SSV}}}Parameters")
    for scalar, value in values.items():
        kind, given = scalar.variable.type, typed(scalar.variable, value or 0.0)
        choice = scalar.variable.choice if choices else None
        parameter = ET.SubElement(held, f"{{{_SSV}}}Parameter", name=scalar.name)
        if choice is None:
            ET.SubElement(parameter, f"{{{_SSV}}}{kind}", value=text(given))
        else:
            ET.SubElement(parameter, f"{{{_SSV}}}Enumeration", value=choice.items[int(given)])
    return document(root)
