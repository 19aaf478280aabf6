"""modelDescription.xml of FMI 2.0 and FMI 3.0 co-simulation from a component's declaration."""

from __future__ import annotations

import json
import uuid
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component
from warmlink.fmus.component.dependencies import TIME
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.attributes import (
    VENDOR,
    accepting_nan,
    array_attributes,
    causality,
    document,
    fmi3_type,
    identity,
    set_within_step,
    text,
    value_attributes,
    variability,
)
from warmlink.fmus.packaging.definitions import type_definitions, unit_definitions
from warmlink.fmus.packaging.exchange import (
    ExchangedState,
    exchanged_states,
    found_dependencies,
    local_identity,
    unknowns_by_kind,
)

LOG_CATEGORIES = {
    "logStatusWarning": "What a user should know of",
    "logStatusDiscard": "Why a step was refused",
    "logStatusError": "What went wrong",
    "logStatusFatal": "Why the instance cannot be used any more",
    "logAll": "Everything",
}

_NAMESPACE = uuid.UUID("5d0f0d6b-2c5e-5a4c-9a53-0c1f6f7a2b11")


def instantiation_token(component: Component, implementation: str = "") -> str:
    """GUID of FMI 2.0 and instantiation token of FMI 3.0, from the interface and what lies behind it.

    Parameters
    ----------
    component : the declaration
    implementation : text that differs between implementations, a hash of their sources, say; libcosim
        takes two FMUs of one GUID for the same one
    """
    interface = [
        (s.name, s.reference, causality(s), variability(s), s.variable.type, s.variable.unit)
        for s in component.scalars()
    ]
    return "{" + str(uuid.uuid5(_NAMESPACE, json.dumps([component.name, interface, implementation]))) + "}"


def fmi2_model_description(
    component: Component,
    *,
    native: bool = True,
    implementation: str = "",
    sources: Sequence[str] = (),
) -> bytes:
    """Write modelDescription.xml for FMI 2.0; the model's identifier is the component's name.

    Every FMU of ours gets, sets and serialises its state, takes any communication step size, and needs no
    tool. A native one also gives directional derivatives and lets hosts integrate the states where nothing is
    sampled; then its inputs may vary within a step as well.

    Parameters
    ----------
    component : the declaration
    native : whether it is in C; pythonfmu, the other form, does without the host's memory callbacks
    implementation : text that differs between implementations, see `instantiation_token`
    sources : names of the files in `sources/` to compile, where there are any
    """
    states = exchanged_states(component) if native else []
    continuous = native and not component.sampled
    found = found_dependencies(component, states)
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": component.name,
            "guid": instantiation_token(component, implementation),
        }
        | _origin(component),
    )
    flags = {
        "canNotUseMemoryManagementFunctions": not native,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": native,
    }
    stepping = {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": continuous}
    exchanging = {"completedIntegratorStepNotNeeded": True} if states else None
    for interface in _interfaces(root, component, flags, stepping, exchanging, continuous):
        files = ET.SubElement(interface, "SourceFiles") if sources else interface
        for name in sources:
            ET.SubElement(files, "File", name=name)
    _common_head(root, component, states)
    accepting = accepting_nan(component)
    if accepting:
        tool = ET.SubElement(ET.SubElement(root, "VendorAnnotations"), "Tool", name=VENDOR)
        ET.SubElement(tool, "acceptsNaN", variables=" ".join(accepting))

    variables = ET.SubElement(root, "ModelVariables")
    for scalar in component.scalars():
        around = ET.SubElement(variables, "ScalarVariable", identity(scalar))
        ET.SubElement(around, scalar.variable.type, value_attributes(scalar))

    # FMI 2.0 counts variables from 1 in the order of their declaration, and time is not one of them.
    index = {s.name: s.reference + 1 for s in component.scalars()}
    for state in states:
        index[state.name] = len(index) + 1
        around = ET.SubElement(variables, "ScalarVariable", local_identity(state.name, state.reference))
        ET.SubElement(around, "Real", unit=state.unit, nominal=text(state.nominal))
    for state in states:
        index[state.rate_name] = len(index) + 1
        around = ET.SubElement(
            variables, "ScalarVariable", local_identity(state.rate_name, state.rate_reference)
        )
        ET.SubElement(around, "Real", unit=state.rate_unit, derivative=str(index[state.name]))
    structure = ET.SubElement(root, "ModelStructure")
    for group, of in unknowns_by_kind(found, states):
        unknowns = ET.SubElement(structure, group + "s") if of else structure
        for name, known in sorted(of.items(), key=lambda item: index[item[0]]):
            attributes = _dependency_attributes(index[k] for k in known if k != TIME)
            ET.SubElement(unknowns, "Unknown", {"index": str(index[name])} | attributes)
    return document(root)


def fmi3_model_description(component: Component, *, implementation: str = "", arrays: bool = False) -> bytes:
    """Write modelDescription.xml for FMI 3.0, whose FMUs are all native; the parameters as for FMI 2.0.

    The independent variable `time` has the value reference after the last of the component's own. With
    `arrays` each vector is one variable, with the value reference of its first element.
    """
    states, continuous = exchanged_states(component), not component.sampled
    found = found_dependencies(component, states)
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "3.0",
            "modelName": component.name,
            "instantiationToken": instantiation_token(component, implementation),
        }
        | _origin(component),
    )
    flags = {
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": True,
    }
    stepping = {
        "canHandleVariableCommunicationStepSize": True,
        "providesIntermediateUpdate": continuous,
        "canReturnEarlyAfterIntermediateUpdate": continuous,
    }
    exchanging = {"needsCompletedIntegratorStep": False} if states else None
    _interfaces(root, component, flags, stepping, exchanging, continuous)
    _common_head(root, component, states)

    variables = ET.SubElement(root, "ModelVariables")
    for scalar in component.scalars():
        whole = arrays and scalar.variable.size is not None
        if whole and scalar.element:
            continue
        attributes = identity(scalar) | value_attributes(scalar)
        if whole:
            attributes |= array_attributes(scalar)
        if continuous and set_within_step(scalar):
            attributes["intermediateUpdate"] = "true"
        around = ET.SubElement(variables, fmi3_type(scalar.variable), attributes)
        if whole:
            ET.SubElement(around, "Dimension", start=str(scalar.variable.size))
    time = {"name": TIME, "valueReference": str(time_reference(component)), "causality": "independent"}
    ET.SubElement(variables, "Float64", time | {"variability": "continuous", "unit": "s"})

    reference = {s.name: s.reference - arrays * s.element for s in component.scalars()}
    reference[TIME] = time_reference(component)
    for state in states:
        reference |= {state.name: state.reference, state.rate_name: state.rate_reference}
        attributes = local_identity(state.name, state.reference)
        attributes |= {"unit": state.unit, "nominal": text(state.nominal)}
        ET.SubElement(variables, "Float64", attributes)
        attributes = local_identity(state.rate_name, state.rate_reference)
        attributes |= {"unit": state.rate_unit, "derivative": str(state.reference)}
        ET.SubElement(variables, "Float64", attributes)
    structure = ET.SubElement(root, "ModelStructure")
    for group, of in unknowns_by_kind(found, states):
        element = "ContinuousStateDerivative" if group == "Derivative" else group
        merged: dict[int, set[int]] = {}
        for name, known in of.items():
            merged.setdefault(reference[name], set()).update(reference[k] for k in known)
        for unknown, on in merged.items():
            attributes = {"valueReference": str(unknown)} | _dependency_attributes(on)
            ET.SubElement(structure, element, attributes)
    accepting = accepting_nan(component)
    if accepting:
        annotation = ET.SubElement(ET.SubElement(root, "Annotations"), "Annotation", type=VENDOR)
        ET.SubElement(annotation, "acceptsNaN", variables=" ".join(accepting))
    return document(root)


def time_reference(component: Component) -> int:
    """Value reference of the independent variable in FMI 3.0."""
    return component.p.size + component.u.size + component.y.size


def _origin(component: Component) -> dict[str, str]:
    return {
        "description": component.description,
        "author": release.AUTHOR,
        "version": release.version(),
        "copyright": release.COPYRIGHT,
        "license": release.LICENSE,
        "generationTool": f"warmlink {release.version()}",
        "generationDateAndTime": f"{release.generated():%Y-%m-%dT%H:%M:%SZ}",
        "variableNamingConvention": "structured",
    }


def _interfaces(
    root: ET.Element,
    component: Component,
    flags: dict[str, bool],
    stepping: dict[str, bool],
    exchanging: dict[str, bool] | None,
    derivatives: bool,
) -> list[ET.Element]:
    """Add what the FMU can be instantiated as: for model exchange where it can, and for co-simulation."""
    added = []
    for kind, own in (("ModelExchange", exchanging), ("CoSimulation", stepping)):
        if own is not None:
            told = {"modelIdentifier": component.name, "needsExecutionTool": "false"}
            told |= {name: text(flag) for name, flag in (flags | own).items()}
            if derivatives and kind == "CoSimulation":
                told["maxOutputDerivativeOrder"] = "1"
            added.append(ET.SubElement(root, kind, told))
    return added


def _common_head(root: ET.Element, component: Component, states: Sequence[ExchangedState]) -> None:
    """Units, types, log categories and default experiment."""
    unit_definitions(root, component, states)
    type_definitions(root, component)
    categories = ET.SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=description)
    experiment = {"startTime": 0.0, "stopTime": component.default_stop_time}
    experiment["stepSize"] = component.default_step_size
    ET.SubElement(root, "DefaultExperiment", {key: text(value) for key, value in experiment.items()})


def _dependency_attributes(known: Iterable[int]) -> dict[str, str]:
    listed = [str(each) for each in sorted(known)]
    return {"dependencies": " ".join(listed), "dependenciesKind": " ".join("dependent" for _ in listed)}
