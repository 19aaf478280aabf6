"""`warmlink export`: a law as plain C for a controller."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from warmlink.fmus.errors import InputError
from warmlink.orchestration.command_line import options
from warmlink.orchestration.command_line.options import Argument, Option
from warmlink.orchestration.console import answer


def export(
    law: Annotated[str, Argument(help="Controller, as `observer`.", propose=options.controllers)],
    design: Annotated[
        Path | None,
        Option(help="Parameter set (SSV) from `warmlink design`. Default: the design that ships."),
    ] = None,
    precision: Annotated[Literal["double", "single"], Option(help="Of the arithmetic.")] = "double",
    out: Annotated[Path | None, Option(help="Folder to write. Default: LAW.")] = None,
) -> None:
    """Write a controller's law as C99 for a robot's or machine's own controller.

    The folder contains the core (a struct, `init` and `step`; no heap, no files, no variables of its own), a
    program that tests it, and a README with its sample time, memory and number of operations.

    Example: `warmlink export observer --design observer.ssv --precision single --out plc`
    """
    from warmlink.controllers.export.core import Core, designed
    from warmlink.controllers.export.folder import export_files
    from warmlink.fmus.component import limits
    from warmlink.orchestration.catalogue import controller
    from warmlink.orchestration.files import fresh_folder
    from warmlink.orchestration.scenarios.overrides import parameters_of
    from warmlink.orchestration.system.shipped import COMPENSATOR
    from warmlink.orchestration.text_files import shortened

    component = controller(law)
    if not component.states:
        raise InputError(f"{law}: has nothing to compute at a sample; export another controller")
    if design is not None:
        own = f"{COMPENSATOR}."
        given = {
            name.removeprefix(own): v for name, v in parameters_of(design).items() if name.startswith(own)
        }
        if not given:
            raise InputError(f"--design {design}: holds nothing for a {COMPENSATOR}; see warmlink design")
        try:
            component = designed(component, given)
        except KeyError as unknown:
            sentence = shortened(str(unknown.args[0]))
            raise InputError(f"--design {design}: {sentence}; give a design of the law {law}") from None
        for sentence in limits.problems(component, law, component.start_values()[0].tolist()):
            raise InputError(f"--design {design}: {sentence}")
    core = Core(component, law, precision)
    folder = out or Path(law)
    with fresh_folder(folder) as scratch:
        for name, text in export_files(core).items():
            (scratch / name).write_text(text, encoding="utf-8")
    answer(f"core  {folder / law}.c    {core.operations()} operations in a step of {core.period:g} s")
