"""What an FMU of FMI 1.0 says of itself, in the words of FMI 2.0 (FMI for Co-Simulation 1.0, section 3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from warmlink.orchestration.system import xml

_TYPES = {f"{name}Type": name for name in ("Real", "Integer", "Boolean", "String", "Enumeration")}


def in_words_of_fmi2(root: Any, where: str, remarks: list[str]) -> Any:
    """Give a description of FMI 1.0 as the elements and attributes that one of FMI 2.0 would have.

    What has no implementation for co-simulation is for model exchange. InputError if a variable or an
    item has no name.
    """
    found = root.makeelement(root.tag, dict(root.attrib))
    identifier = {"modelIdentifier": xml.required(root, "modelIdentifier", where)}
    if root.find("Implementation") is None:
        _child(found, "ModelExchange", identifier)
    else:
        said = next(root.iterfind("Implementation/*/Capabilities"), None)
        flags = {} if said is None else dict(said.attrib)
        flags.pop("canInterpolateInputs", None)  # no derivatives are set
        _child(found, "CoSimulation", {**flags, **identifier})
    units = _child(found, "UnitDefinitions", {})
    for unit in root.iterfind("UnitDefinitions/BaseUnit"):
        _child(units, "Unit", {"name": xml.required(unit, "unit", where)})
    types = _child(found, "TypeDefinitions", {})
    for declared in root.iterfind("TypeDefinitions/Type"):
        simple = _child(types, "SimpleType", declared.attrib)
        for typed in (each for each in declared if each.tag in _TYPES):
            _with_numbered_items(_child(simple, _TYPES[typed.tag], typed.attrib), typed)
    for experiment in root.iterfind("DefaultExperiment"):
        _child(found, "DefaultExperiment", experiment.attrib)
    variables = _child(found, "ModelVariables", {})
    outputs = _child(_child(found, "ModelStructure", {}), "Outputs", {})
    declared_variables = _named_once(root.iterfind("ModelVariables/ScalarVariable"), remarks)
    numbers = {each.get("name"): str(i) for i, each in enumerate(declared_variables, start=1)}
    for number, each in enumerate(declared_variables, start=1):
        variable = _child(variables, "ScalarVariable", {**each.attrib, **_roles(each)})
        for typed in each:
            if typed.tag in _TYPES.values():
                _child(variable, typed.tag, typed.attrib)
        if each.get("causality") == "output":
            unknown = _child(outputs, "Unknown", {"index": str(number)})
            known = each.find("DirectDependency")
            if known is not None:
                names = [numbers[n.text] for n in known.iterfind("Name") if n.text in numbers]
                unknown.set("dependencies", " ".join(names))
    return found


def _named_once(variables: Iterable[Any], remarks: list[str]) -> list[Any]:
    """Leave out internal variables whose name another one has already: nobody connects or sets them."""
    found, names = [], set()
    for each in variables:
        name = each.get("name")
        if name in names and each.get("causality", "internal") in ("internal", "none"):
            remarks.append(f"declares the variable {name} twice; the second, which is internal, is left out")
        else:
            found.append(each)
            names.add(name)
    return found


def _child(parent: Any, tag: str, attributes: Mapping[str, str]) -> Any:
    made = parent.makeelement(tag, dict(attributes))
    parent.append(made)
    return made


def _with_numbered_items(target: Any, typed: Any) -> None:
    """Give an enumeration its items, which FMI 1.0 counts from 1 in their order."""
    for number, item in enumerate(typed.iterfind("Item"), start=1):
        _child(target, "Item", {**item.attrib, "value": str(number)})


def _roles(variable: Any) -> dict[str, str]:
    """Give causality, variability and initial of a variable, as FMI 2.0 calls them."""
    causality = variable.get("causality", "internal")
    variability = variable.get("variability", "continuous")
    typed = next((each for each in variable if each.tag in _TYPES.values()), None)
    started = typed is not None and typed.get("start") is not None
    guess = typed is not None and typed.get("fixed") in ("false", "0")
    if causality not in ("input", "output"):
        causality = "parameter" if variability == "parameter" else "local"
    if variability == "parameter":
        variability = "fixed"
    exact = variability == "constant" or causality in ("input", "parameter")
    initial = ("approx" if guess else "exact") if started else "exact" if exact else "calculated"
    return {"causality": causality, "variability": variability, "initial": initial}
