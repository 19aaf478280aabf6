"""A law as C for a robot's or machine's own controller."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from warmlink.controllers.export.c_files import export_files
from warmlink.controllers.export.core import Core, Precision, designed
from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.catalogue import controller_named
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.machine.machine import COMPENSATOR
from warmlink.orchestration.scenarios.overrides import given_values, start_values


@dataclass(frozen=True, repr=False)
class Exported(Answer):
    """A law's C: the core, a program that tests it, and a README, as texts by the name of their files."""

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
    precision: Precision = "double",
) -> Exported:
    """Give a controller's law as C99 for a robot's or machine's own controller.

    Parameters
    ----------
    law : controller, as `observer`, or a law of one's own, as `my_law.py:MyLaw`
    design : parameter set (SSV) from `design`, or its values by name; the design that ships by default
    precision : of the arithmetic, double or single

    Raises
    ------
    InputError
        If there is no such law, it computes nothing at a sample, or the design is not for it.

    Examples
    --------
    >>> wl.export("observer", "observer.ssv", precision="single").write("plc")
    """
    found = controller_named(law)
    name, component = found.name, found.component
    if not component.states:
        raise InputError(f"{name}: has nothing to compute at a sample; export another controller")
    if design is not None:
        where = str(design) if isinstance(design, (str, Path)) else "design"
        every = given_values(design)
        given = {each: value for each, value in every.items() if each.startswith(f"{COMPENSATOR}.")}
        if not given:
            raise InputError(f"{where}: holds nothing for a {COMPENSATOR}; give the values of a design")
        values = start_values(given, {COMPENSATOR: component}, where)[COMPENSATOR]
        component = designed(component, {each: float(value) for each, value in values.items()})
    if precision not in get_args(Precision):
        told = instead(str(precision), get_args(Precision))
        raise InputError(f"{argument('precision', precision)}: no such arithmetic; {told}")
    core = Core(component, name, precision)
    return Exported(core, export_files(core))
