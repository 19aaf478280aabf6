"""A law for a robot's or machine's own controller: as C, or as Structured Text."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from warmlink.controllers.export.c_files import export_files, readme
from warmlink.controllers.export.core import Core, Precision, designed
from warmlink.controllers.export.program.places import RESERVED
from warmlink.controllers.export.st_files import st_files
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.catalogue import controller_named
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import fresh_folder, with_hash
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.products.measured import measured
from warmlink.orchestration.scenarios.overrides import given_values, start_values
from warmlink.orchestration.system.ssp.parameter_values import description_of

Language = Literal["c", "st"]
"""What a law is written in: C99, or Structured Text of IEC 61131-3."""


@dataclass(frozen=True, repr=False)
class Exported(Answer):
    """A law in a controller's language, with a README, as texts by the name of their files."""

    core: Core
    files: Mapping[str, str]

    @property
    def name(self) -> str:
        """Name of the law, after which files and functions are named."""
        return self.core.name

    def summary(self) -> str:
        """Files, and what a step takes."""
        step = f"{self.core.operations()} operations in a step of {self.core.period:g} s"
        return f"{self.name}: {', '.join(self.files)}; {step}"

    def write(self, folder: str | Path) -> None:
        """Write the files into a folder, all or none; InputError if that is not possible."""
        with fresh_folder(Path(folder)) as scratch:
            for name, text in self.files.items():
                (scratch / name).write_text(text, encoding="utf-8")


def export(
    law: str,
    design: str | Path | Mapping[str, str | float] | None = None,
    *,
    to: Language = "c",
    precision: Precision = "double",
) -> Exported:
    """Give a controller's law in the language of a robot's or machine's own controller.

    Parameters
    ----------
    law : controller, as `observer`, or a law of one's own, as `my_law.py:MyLaw`
    design : parameter set (SSV) from `design`, or its values by name; the design that ships by default
    to : `c` for C99; `st` for Structured Text of IEC 61131-3, one function block, also as PLCopen XML
    precision : of the arithmetic, double (LREAL) or single (REAL)

    Raises
    ------
    InputError
        If there is no such law, it computes nothing at a sample, or in a way that cannot be written down, or
        the design is not for it.

    Examples
    --------
    >>> wl.export("observer", "observer.ssv", precision="single").write("plc")
    >>> wl.export("regression", to="st").write("plc")
    """
    name, component, source = law_of(law, design)
    name = re.sub(r"\W+", "_", name)
    name = f"law_{name}" if name.lower() in RESERVED or not name.isidentifier() else name
    for argued, given, known in (("precision", precision, Precision), ("to", to, Language)):
        if given not in get_args(known):
            what = "no such arithmetic" if argued == "precision" else "no such language"
            raise InputError(f"{argument(argued, given)}: {what}; {instead(str(given), get_args(known))}")
    core = Core(component, name, precision, source)
    try:
        files = export_files(core) if to == "c" else st_files(core)
        if to == "c":
            files["README.md"] = readme(core, measured(core, files))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    return Exported(core, files)


def law_of(law: str, design: str | Path | Mapping[str, str | float] | None) -> tuple[str, Component, str]:
    """A law's name, its component with the values of a design, and what that design is called.

    Raises InputError if there is no such law, it computes nothing at a sample, or the design is not for it.
    """
    found = controller_named(law)
    name, component, source = found.name, found.component, Core.source_of_design
    if not component.states:
        raise InputError(f"{name}: has nothing to compute at a sample; export another controller")
    if design is not None:
        where = str(design) if isinstance(design, (str, Path)) else "design"
        every = given_values(design, "design")
        given = {each: value for each, value in every.items() if each.startswith(f"{COMPENSATOR}.")}
        if not given:
            raise InputError(f"{where}: holds nothing for a {COMPENSATOR}; give the values of a design")
        values = start_values(given, {COMPENSATOR: component}, where)[COMPENSATOR]
        component = designed(component, {each: float(value) for each, value in values.items()})
        source = "values given by name"
        if isinstance(design, (str, Path)):
            source = ", ".join((with_hash(design), *filter(None, [description_of(Path(design))])))
    return name, component, source
