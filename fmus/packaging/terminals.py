"""terminalsAndIcons.xml: which variables of an FMU belong together where FMUs are connected."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.attributes import document


def terminals_files(component: Component, arrays: bool = False) -> dict[str, bytes]:
    """Give terminalsAndIcons.xml by its path inside an FMU; nothing for a component without terminals.

    FMI 2.0 does not know the file, and gets it as FMI 3.0 has it (section 2.4.9 there). Members are
    connected by their names, and each is given by one side as a signal. With `arrays` an array is one member,
    whose name has no number.
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
        members = list(terminal.members)
        if arrays:
            whole = {s.name: s.variable.name for s in component.scalars() if s.variable.size is not None}
            numbered = ((re.sub(r"_\d+", "", m) if s in whole else m, whole.get(s, s)) for m, s in members)
            members = list(dict.fromkeys(numbered))
        for member, scalar in members:
            told = {"variableName": scalar, "memberName": member, "variableKind": "signal"}
            ET.SubElement(around, "TerminalMemberVariable", told)
    return {"terminalsAndIcons/terminalsAndIcons.xml": document(root)}
