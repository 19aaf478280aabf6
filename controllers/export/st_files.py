"""A law's files for a controller that speaks IEC 61131-3."""

from __future__ import annotations

from warmlink.controllers.export.core import Core
from warmlink.controllers.export.plcopen import plcopen_xml
from warmlink.controllers.export.st_blocks import structured_text
from warmlink.controllers.export.texts import filled, listed, parameters

_RESTART = """
## After the controller was off

`retained` keeps, over a restart, what the law had learnt of the machine. Give `passed` the time in s for
which the controller was off, with the first call; below 0, the start value, it is unknown and nothing is
recalled. What does not add up, as after another program was loaded, is not used: the law then starts unsure,
and is ready later.
"""


def st_files(core: Core) -> dict[str, str]:
    """Text of each file of an export to Structured Text by name."""
    return {
        f"{core.name}.st": structured_text(core),
        f"{core.name}.xml": plcopen_xml(core),
        "README.md": _readme(core),
    }


def _readme(core: Core) -> str:
    made = core.program
    return filled(
        core,
        "st_readme.txt",
        origin="\n".join(core.origin()),
        real="REAL" if core.precision == "single" else "LREAL",
        more=_RESTART if core.goes_on else "",
        inputs=listed(made.inputs),
        outputs=listed([slot for slot in made.outputs if slot.name != "retained"]),
        constants=sum(slot.size for slot in made.design),
        states=sum(slot.size for slot in made.states),
        operations=core.operations(),
        parameters=parameters(core),
    )
