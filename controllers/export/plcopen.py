"""A law's function blocks as PLCopen XML (TC6, version 2.01), which development environments import."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.st_blocks import blocks
from warmlink.controllers.export.st_text import BlockText, Declaration
from warmlink.fmus.packaging.release import generated, version

NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"

_SECTIONS = {
    "VAR_INPUT": ("inputVars", {}),
    "VAR_OUTPUT": ("outputVars", {}),
    "VAR_IN_OUT": ("inOutVars", {}),
    "VAR CONSTANT": ("localVars", {"constant": "true"}),
    "VAR RETAIN": ("localVars", {"retain": "true"}),
    "VAR": ("localVars", {}),
}
"""What sections of variables are called, and their attributes."""

_ELEMENTARY = frozenset({"BOOL", "INT", "LINT", "REAL", "LREAL"})


def plcopen_xml(core: Core) -> str:
    """The law's types, functions and function blocks as one XML document."""
    made = blocks(core)
    project = ET.Element("project", xmlns=NAMESPACE)
    when = generated().strftime("%Y-%m-%dT%H:%M:%S")
    ET.SubElement(
        project,
        "fileHeader",
        companyName="warmlink",
        productName="warmlink",
        productVersion=version(),
        creationDateTime=when,
        contentDescription=" ".join(core.origin()),
    )
    content = ET.SubElement(project, "contentHeader", name=core.name)
    coordinates = ET.SubElement(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        ET.SubElement(ET.SubElement(coordinates, language), "scaling", x="1", y="1")
    types = ET.SubElement(project, "types")
    data, units = ET.SubElement(types, "dataTypes"), ET.SubElement(types, "pous")
    for name, size, of in made.arrays:
        base = ET.SubElement(ET.SubElement(data, "dataType", name=name), "baseType")
        _array(base, size, of)
    name, fields = made.state
    base = ET.SubElement(ET.SubElement(data, "dataType", name=name), "baseType")
    struct = ET.SubElement(base, "struct")
    for each in fields:
        _variable(struct, each)
    for unit in made.units:
        _unit(units, unit)
    ET.SubElement(ET.SubElement(project, "instances"), "configurations")
    ET.indent(project)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ET.tostring(project, "unicode")}\n'


def _unit(units: ET.Element, unit: BlockText) -> None:
    kind = "function" if unit.head == "FUNCTION" else "functionBlock"
    pou = ET.SubElement(units, "pou", name=unit.name, pouType=kind)
    interface = ET.SubElement(pou, "interface")
    if unit.returns:
        _type(ET.SubElement(interface, "returnType"), unit.returns)
    for word, variables in unit.sections.items():
        if variables:
            tag, attributes = _SECTIONS[word]
            section = ET.SubElement(interface, tag, attributes)
            for each in variables:
                _variable(section, each)
    body = ET.SubElement(ET.SubElement(pou, "body"), "ST")
    ET.SubElement(body, "xhtml", xmlns=XHTML).text = "\n".join(unit.body)
    if unit.about:
        _told(pou, unit.about)


def _variable(section: ET.Element, variable: Declaration) -> None:
    made = ET.SubElement(section, "variable", name=variable.name)
    _type(ET.SubElement(made, "type"), variable.type)
    if variable.start:
        initial = ET.SubElement(made, "initialValue")
        if len(variable.start) == 1:
            ET.SubElement(initial, "simpleValue", value=variable.start[0])
        else:
            values = ET.SubElement(initial, "arrayValue")
            for each in variable.start:
                ET.SubElement(ET.SubElement(values, "value"), "simpleValue", value=each)
    if variable.told:
        _told(made, variable.told)


def _type(parent: ET.Element, name: str) -> None:
    if name in _ELEMENTARY:
        ET.SubElement(parent, name)
    elif name.startswith("ARRAY"):
        last, of = name.removeprefix("ARRAY [0..").split("] OF ")
        _array(parent, int(last) + 1, of)
    else:
        ET.SubElement(parent, "derived", name=name)


def _array(parent: ET.Element, size: int, of: str) -> None:
    array = ET.SubElement(parent, "array")
    ET.SubElement(array, "dimension", lower="0", upper=str(size - 1))
    ET.SubElement(ET.SubElement(array, "baseType"), of)


def _told(parent: ET.Element, text: str) -> None:
    ET.SubElement(ET.SubElement(parent, "documentation"), "xhtml", xmlns=XHTML).text = text
