"""terminalsAndIcons.xml: which variables of an FMU belong together where FMUs are connected."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.attributes import document


def terminals_files(component: Component) -> dict[str, bytes]:
    """Give terminalsAndIcons.xml by its path inside an FMU; nothing for a component without terminals.

    FMI 2.0 does not know the file, and gets it as FMI 3.0 has it (section 2.4.9 there). Members are
    connected by their names, and each is given by one side as a signal.
    """
    if not component.terminals:
        return {}
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = ET.SubElement(root, "Terminals")
    for terminal in component.terminals:
        attributes = {
            "name": terminal.name,
            "matchingRule": "bus",
            "terminalKind": f"warmlink.{terminal.kind}",
        }
        around = ET.SubElement(terminals, "Terminal", attributes)
        for member, scalar in terminal.members:
            told = {"variableName": scalar, "memberName": member, "variableKind": "signal"}
            ET.SubElement(around, "TerminalMemberVariable", told)
    return {"terminalsAndIcons/terminalsAndIcons.xml": document(root)}
