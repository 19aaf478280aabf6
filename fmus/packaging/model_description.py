"""modelDescription.xml of FMI 2.0 and FMI 3.0 from a component's declaration."""

import json
import uuid
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component
from warmlink.fmus.component.dependencies import TIME, dependencies
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.attributes import (
    VENDOR,
    Attributes,
    add,
    add_types,
    add_units,
    document,
    fmi3_type,
    identity,
    value_attributes,
)
from warmlink.fmus.packaging.views import ExchangedState, exchanged_states

LOG_CATEGORIES = {
    "logStatusWarning": "What a user should know of",
    "logStatusDiscard": "Why a step was refused",
    "logStatusError": "What went wrong",
    "logStatusFatal": "Why the instance cannot be used any more",
    "logAll": "Everything",
}

_NAMESPACE = uuid.UUID("5d0f0d6b-2c5e-5a4c-9a53-0c1f6f7a2b11")


def instantiation_token(component: Component, implementation: str = "") -> str:
    """GUID of FMI 2.0 and instantiation token of FMI 3.0, from the interface and the text `implementation`.

    That differs between implementations, as a hash of their sources does: libcosim takes two FMUs of one GUID
    for the same one.
    """
    told = [(s, identity(s)) for s in component.scalars()]
    interface = [
        (s.name, s.reference, of["causality"], of["variability"], s.variable.type, s.variable.unit)
        for s, of in told
    ]
    return "{" + str(uuid.uuid5(_NAMESPACE, json.dumps([component.name, interface, implementation]))) + "}"


def tables_mark(component: Component) -> str:
    """What the token of a component goes on with in a model description, by the tables that it plays.

    FMUs that differ in these alone have one library, which takes any such mark.
    """
    return "".join(f"-{played.table.digest[:16]}" for played in component.tables)


def model_description(
    component: Component,
    fmi_version: str = "2.0",
    *,
    native: bool = True,
    implementation: str = "",
    sources: Sequence[str] = (),
    arrays: bool = False,
) -> bytes:
    """Write modelDescription.xml; the model's identifier is the component's name.

    Every FMU of ours gets, sets and serialises its state, takes any communication step size, and needs no
    tool. A native one also gives directional derivatives and lets hosts integrate the states where nothing is
    sampled; then its inputs may vary within a step as well.

    Parameters
    ----------
    fmi_version : "2.0" or "3.0"; FMUs of FMI 3.0 are all native, and their independent variable `time` has
        the value reference after the last of the component's own
    native : whether it is in C; pythonfmu, the other form, does without the host's memory callbacks
    implementation : text that differs between implementations, see `instantiation_token`
    sources : in FMI 2.0, names of the files in `sources/` to compile, where there are any
    arrays : in FMI 3.0, each vector is one variable, with the value reference of its first element
    """
    modern = fmi_version == "3.0"
    states = exchanged_states(component) if native else []
    root = ET.Element("fmiModelDescription", {"fmiVersion": fmi_version, "modelName": component.name})
    token = instantiation_token(component, implementation) + tables_mark(component)
    root.set("instantiationToken" if modern else "guid", token)
    root.attrib |= {
        "description": component.description,
        "author": release.AUTHOR,
        "version": release.version(),
        "copyright": release.COPYRIGHT,
        "license": release.LICENSE,
        "generationTool": f"warmlink {release.version()}",
        "generationDateAndTime": f"{release.generated():%Y-%m-%dT%H:%M:%SZ}",
        "variableNamingConvention": "structured",
    }
    _add_interfaces(root, component, modern, native, () if modern else sources)
    declared = [*component.inputs, *component.parameters, *component.outputs]
    add_units(root, declared, [scalar.variable.unit for state in states for scalar in state])
    add_types(root, declared, fmi_version)
    categories = add(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        add(categories, "Category", name=name, description=description)
    times = {"stopTime": component.default_stop_time, "stepSize": component.default_step_size}
    add(root, "DefaultExperiment", {"startTime": 0.0}, **times)
    if not modern:
        _annotate(root, component, "VendorAnnotations", "Tool", "name")
    _add_variables(root, component, states, modern, arrays)
    _add_structure(root, component, states, modern, arrays)
    if modern:
        _annotate(root, component, "Annotations", "Annotation", "type")
    return document(root)


def time_reference(component: Component) -> int:
    """Value reference of the independent variable in FMI 3.0."""
    return component.p.size + component.u.size + component.y.size


def _add_interfaces(
    root: ET.Element, component: Component, modern: bool, native: bool, sources: Sequence[str]
) -> None:
    """Add what the FMU can be instantiated as: for model exchange where it can, and for co-simulation."""
    continuous = native and not component.sampled
    within: tuple[str, ...] = ("canInterpolateInputs",)
    if modern:
        flags = {"canGetAndSetFMUState": True, "canSerializeFMUState": True}
        flags["providesDirectionalDerivatives"] = native
        exchanging = {"needsCompletedIntegratorStep": False}
        within = ("providesIntermediateUpdate", "canReturnEarlyAfterIntermediateUpdate")
    else:
        flags = {"canNotUseMemoryManagementFunctions": not native, "canGetAndSetFMUstate": True}
        flags |= {"canSerializeFMUstate": True, "providesDirectionalDerivative": native}
        exchanging = {"completedIntegratorStepNotNeeded": True}
    stepping = {"canHandleVariableCommunicationStepSize": True, **dict.fromkeys(within, continuous)}
    kinds: dict[str, Attributes] = {"ModelExchange": exchanging} if continuous and component.states else {}
    kinds["CoSimulation"] = {**stepping, "maxOutputDerivativeOrder": 1 if continuous else None}
    for kind, own in kinds.items():
        called = {"modelIdentifier": component.name, "needsExecutionTool": "false"}
        interface = add(root, kind, called, **flags, **own)
        files = add(interface, "SourceFiles") if sources else interface
        for name in sources:
            add(files, "File", name=name)


def _annotate(root: ET.Element, component: Component, around: str, tag: str, key: str) -> None:
    """Name the inputs that cope with a missing value."""
    accepting = [name for each in component.inputs if each.accepts_nan for name in each.scalar_names]
    if accepting:
        add(add(add(root, around), tag, {key: VENDOR}), "acceptsNaN", variables=" ".join(accepting))


def _add_variables(
    root: ET.Element, component: Component, states: Sequence[ExchangedState], modern: bool, arrays: bool
) -> None:
    variables = add(root, "ModelVariables")

    def declare(named: Attributes, kind: str, attributes: Attributes) -> ET.Element:
        if modern:
            return add(variables, kind, {**named, **attributes})
        return add(add(variables, "ScalarVariable", named), kind, attributes)

    for scalar in component.scalars():
        variable, whole = scalar.variable, arrays and scalar.variable.size is not None
        if whole and scalar.element:
            continue
        named = identity(scalar) | ({"name": variable.name} if whole else {})
        varies = named["causality"] == "input" and named["variability"] == "continuous"
        within = True if modern and varies and not component.sampled else None
        attributes = {**value_attributes(scalar, whole), "intermediateUpdate": within}
        declared = declare(named, fmi3_type(variable) if modern else variable.type, attributes)
        if whole:
            add(declared, "Dimension", start=variable.size)
    if modern:
        time = {"name": TIME, "valueReference": time_reference(component), "causality": "independent"}
        add(variables, "Float64", time, variability="continuous", unit="s")

    # In FMI 3.0 each rate follows its state.
    local = [
        (each, None if each is state else state.reference) for state, rate in states for each in (state, rate)
    ]
    for scalar, of in local if modern else sorted(local, key=lambda each: each[0].reference):
        about = {"unit": scalar.variable.unit, "nominal": scalar.variable.nominal, "derivative": of}
        declare(identity(scalar), "Float64" if modern else "Real", about)


def _add_structure(
    root: ET.Element, component: Component, states: Sequence[ExchangedState], modern: bool, arrays: bool
) -> None:
    """Add what each unknown depends on.

    FMI 3.0 goes by value references. FMI 2.0 counts variables from 1 in the order of their declaration, and
    time is not one of them: so what follows time in FMI 3.0 has the same number in both.
    """
    number = {s.name: s.reference - s.element if arrays else s.reference for s in component.scalars()}
    number = number | {TIME: time_reference(component)} if modern else {k: n + 1 for k, n in number.items()}
    number |= {scalar.name: scalar.reference for state in states for scalar in state}
    rates = tuple(rate.name for _, rate in states)
    found = dependencies(component, tuple(state.name for state, _ in states), rates)
    kinds: dict[str, dict[str, tuple[str, ...]]] = {"Output": {}, "Derivative": {}}
    for name, known in found.outputs.items():
        kinds["Derivative" if name in rates else "Output"][name] = known
    kinds["InitialUnknown"] = found.initial
    structure = add(root, "ModelStructure")
    for kind, of in kinds.items():
        merged: dict[int, set[int]] = {}
        for name, known in of.items():
            merged.setdefault(number[name], set()).update(number[k] for k in known if k in number)
        group = add(structure, f"{kind}s") if of and not modern else structure
        tag = "ContinuousStateDerivative" if kind == "Derivative" else kind
        for unknown in merged if modern else sorted(merged):
            listed = sorted(merged[unknown])
            on = {
                "valueReference" if modern else "index": unknown,
                "dependencies": " ".join(map(str, listed)),
            }
            on["dependenciesKind"] = " ".join(["dependent"] * len(listed))
            add(group, tag if modern else "Unknown", on)
