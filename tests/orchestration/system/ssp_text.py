"""FMUs without binaries and SSPs from a few words: reading and refusing are tested in milliseconds."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.model import System

BASE_UNITS = {
    "K": 'K="1"',
    "degC": 'K="1" offset="273.15"',
    "W": 'kg="1" m="2" s="-3"',
    "m": 'm="1"',
    "mm": 'm="1" factor="0.001"',
    "um": 'm="1" factor="1e-6"',
}
LINEAR = '<ssc:LinearTransformation factor="2" offset="1"/>'
NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
)


def fmi2_variable(
    name: str, causality: str, kind: str = "Real", attributes: str = "", outer: str = ""
) -> str:
    """Give one ScalarVariable without its value reference, which follows from its place."""
    told = f'name="{name}" valueReference="@" causality="{causality}" {outer}'
    return f"<ScalarVariable {told}><{kind} {attributes}/></ScalarVariable>"


MOTOR = (
    fmi2_variable("ambient", "input", attributes='unit="K" start="295.15"'),
    fmi2_variable("link_temperature", "input", attributes='unit="degC" start="20"'),
    fmi2_variable("mode", "input", "Integer", 'start="0"', 'variability="discrete"'),
    fmi2_variable("heat_flow", "output", attributes='unit="W"'),
    fmi2_variable("shaft_temperature", "output", attributes='unit="K"'),
    fmi2_variable("rise", "output", attributes='unit="degC" relativeQuantity="true"'),
    fmi2_variable("steps", "output", "Integer", "", 'variability="discrete"'),
    fmi2_variable("torque_constant", "parameter", attributes='start="1.2"', outer='variability="fixed"'),
)
LINK = (
    fmi2_variable("heat_flow", "input", attributes='unit="W" start="0"'),
    fmi2_variable("ambient", "input", attributes='unit="K" start="295.15"'),
    fmi2_variable("difference", "input", attributes='unit="K" relativeQuantity="true" start="0"'),
    fmi2_variable("mode", "input", "Integer", 'start="0"', 'variability="discrete"'),
    fmi2_variable("temperature", "output", attributes='unit="K"'),
    fmi2_variable("elongation", "output", attributes='unit="m"'),
    fmi2_variable(
        "length",
        "parameter",
        attributes='unit="m" start="0.33" min="0" max="10"',
        outer='variability="fixed"',
    ),
    fmi2_variable("cells", "parameter", "Integer", 'start="40" min="2"', 'variability="fixed"'),
    fmi2_variable("radiates", "parameter", "Boolean", 'start="false"', 'variability="fixed"'),
    fmi2_variable("label", "parameter", "String", 'start="link"', 'variability="fixed"'),
    fmi2_variable(
        "metal", "parameter", "Enumeration", 'declaredType="Metal" start="1"', 'variability="fixed"'
    ),
    fmi2_variable("rate", "calculatedParameter", attributes='unit="K"', outer='variability="fixed"'),
)
METAL = (
    '<SimpleType name="Metal"><Enumeration><Item name="steel" value="1"/><Item name="brass" value="2"/>'
    "</Enumeration></SimpleType>"
)


def fmi2(name: str, variables: tuple[str, ...], interface: str = "CoSimulation", structure: str = "") -> str:
    """Give a modelDescription.xml of FMI 2.0."""
    units = "".join(f'<Unit name="{k}"><BaseUnit {v}/></Unit>' for k, v in BASE_UNITS.items())
    numbered = "".join(v.replace("@", str(i)) for i, v in enumerate(variables))
    return (
        f'<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{{{name}}}">'
        f'<{interface} modelIdentifier="{name}" canGetAndSetFMUstate="true" maxOutputDerivativeOrder="1"/>'
        f"<UnitDefinitions>{units}</UnitDefinitions><TypeDefinitions>{METAL}</TypeDefinitions>"
        f'<DefaultExperiment startTime="0" stopTime="10" stepSize="0.5" tolerance="1e-5"/>'
        f"<ModelVariables>{numbered}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
        "</fmiModelDescription>"
    )


def write_zip(path: Path, entries: dict[str, str | bytes]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return path


def connector(name: str, kind: str, typed: str = "") -> str:
    return f'<ssd:Connector name="{name}" kind="{kind}">{typed}</ssd:Connector>'


def component(name: str, fmu: str, connectors: str = "", bindings: str = "", attributes: str = "") -> str:
    held = f"<ssd:Connectors>{connectors}</ssd:Connectors>" if connectors else ""
    bound = f"<ssd:ParameterBindings>{bindings}</ssd:ParameterBindings>" if bindings else ""
    return f'<ssd:Component name="{name}" source="{fmu}" {attributes}>{held}{bound}</ssd:Component>'


def connection(start: str, end: str, inside: str = "", attributes: str = "") -> str:
    """Connect `element.connector` ends; a name without dot is the enclosing system's."""
    parts = []
    for label, name in (("start", start), ("end", end)):
        owner, _, own = name.rpartition(".")
        parts.append((f'{label}Element="{owner}" ' if owner else "") + f'{label}Connector="{own}"')
    return f"<ssd:Connection {' '.join(parts)} {attributes}>{inside}</ssd:Connection>"


def system(
    elements: str = "", connections: str = "", name: str = "cell", before: str = "", after: str = ""
) -> str:
    linked = f"<ssd:Connections>{connections}</ssd:Connections>" if connections else ""
    held = f"<ssd:Elements>{elements}</ssd:Elements>" if elements else ""
    return f'<ssd:System name="{name}">{before}{held}{linked}{after}</ssd:System>'


def ssd(root: str, version: str = "1.0", after: str = "") -> str:
    """Give a whole SSD around a System element, with the units of these tests."""
    units = "".join(f'<ssc:Unit name="{k}"><ssc:BaseUnit {v}/></ssc:Unit>' for k, v in BASE_UNITS.items())
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription {NAMESPACES} '
        f'version="{version}" name="cell">{root}<ssd:Units>{units}</ssd:Units>{after}'
        "</ssd:SystemStructureDescription>"
    )


def parameters(*entries: str, name: str = "parameters") -> str:
    """Give an inline binding with entries such as `length:Real:330:mm`."""
    return binding(f"<ssd:ParameterValues>{ssv(*entries, name=name)}</ssd:ParameterValues>")


def binding(inside: str = "", attributes: str = "") -> str:
    return f"<ssd:ParameterBinding {attributes}>{inside}</ssd:ParameterBinding>"


def mapping(entries: str) -> str:
    """Give an inline mapping of `ssm:MappingEntry` elements."""
    return f"<ssd:ParameterMapping>{ssm(entries)}</ssd:ParameterMapping>"


def ssm(entries: str) -> str:
    return f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{entries}</ssm:ParameterMapping>'


def entry(source: str, target: str, inside: str = "", attributes: str = "") -> str:
    return f'<ssm:MappingEntry source="{source}" target="{target}" {attributes}>{inside}</ssm:MappingEntry>'


def ssv(*entries: str, name: str = "parameters") -> str:
    held = ""
    for entry in entries:
        key, kind, value, *unit = entry.split(":")
        told = f' unit="{unit[0]}"' if unit else ""
        held += f'<ssv:Parameter name="{key}"><ssv:{kind} value="{value}"{told}/></ssv:Parameter>'
    units = "".join(f'<ssc:Unit name="{k}"><ssc:BaseUnit {v}/></ssc:Unit>' for k, v in BASE_UNITS.items())
    return (
        f'<ssv:ParameterSet {NAMESPACES} version="1.0" name="{name}">'
        f"<ssv:Parameters>{held}</ssv:Parameters><ssv:Units>{units}</ssv:Units></ssv:ParameterSet>"
    )


MOTOR_CONNECTORS = "".join(
    connector(*c)
    for c in (
        ("ambient", "input", '<ssc:Real unit="K"/>'),
        ("link_temperature", "input", '<ssc:Real unit="degC"/>'),
        ("mode", "input", "<ssc:Integer/>"),
        ("heat_flow", "output", '<ssc:Real unit="W"/>'),
        ("shaft_temperature", "output"),
        ("rise", "output"),
        ("steps", "output", "<ssc:Integer/>"),
        ("torque_constant", "parameter", "<ssc:Real/>"),
    )
)
LINK_CONNECTORS = "".join(
    connector(*c)
    for c in (
        ("heat_flow", "input", '<ssc:Real unit="W"/>'),
        ("ambient", "input", '<ssc:Real unit="K"/>'),
        ("difference", "input"),
        ("mode", "input", "<ssc:Integer/>"),
        ("temperature", "output", '<ssc:Real unit="K"/>'),
        ("elongation", "output", '<ssc:Real unit="m"/>'),
        ("length", "parameter", '<ssc:Real unit="m"/>'),
        ("rate", "calculatedParameter", "<ssc:Real/>"),
    )
)


class Lab:
    """Makes SSPs in a folder and reads them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.count = 0

    def entries(self) -> dict[str, str | bytes]:
        """Give the two FMUs of these tests under the names that SSDs refer to."""
        made: dict[str, str | bytes] = {}
        for name, variables in (("Motor", MOTOR), ("Link", LINK)):
            path = write_zip(self.folder / f"{name}.fmu", {"modelDescription.xml": fmi2(name, variables)})
            made[f"resources/{name}.fmu"] = path.read_bytes()
        return made

    def fmu(self, name: str, text: str) -> Path:
        return write_zip(self.folder / f"{name}.fmu", {"modelDescription.xml": text})

    def ssp(self, text: str, more: dict[str, str | bytes] | None = None) -> Path:
        self.count += 1
        entries = {"SystemStructure.ssd": text, **self.entries(), **(more or {})}
        return write_zip(self.folder / f"cell{self.count}.ssp", entries)

    def read(self, text: str, more: dict[str, str | bytes] | None = None) -> System:
        return read_system(self.ssp(text, more), self.folder / "work")

    def cell(self, connections: str = "", motor: str = "", link: str = "", **rest: str) -> str:
        """Give the SSD of a motor and a link with the given connections and bindings."""
        elements = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS, motor)
        elements += component("link", "resources/Link.fmu", LINK_CONNECTORS, link)
        return ssd(system(elements, connections, **rest))


@dataclass(frozen=True)
class Case:
    """An SSD and the sentence that refuses it."""

    name: str
    text: str
    sentence: str


def cell(*connections: str, motor: str = "", link: str = "", before: str = "", after: str = "") -> str:
    elements = component("motor", "resources/Motor.fmu", MOTOR_CONNECTORS, motor)
    elements += component("link", "resources/Link.fmu", LINK_CONNECTORS, link)
    return ssd(system(elements, "".join(connections), before=before, after=after))


def alone(
    connectors: str = "", bindings: str = "", attributes: str = "", fmu: str = "resources/Link.fmu"
) -> str:
    return ssd(system(component("link", fmu, connectors, bindings, attributes)))
