"""Weighted sums of a machine's outputs, which a column may hold in place of one output.

As a sum of growths `x.elongation + y.elongation`, or what one thermometer reads more than another:
`link.base_temperature - link.tip_temperature`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from warmlink.fmus.component import Output, Scalar
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.machine.rig import Rig
from warmlink.orchestration.machine.roles import WeightedSum
from warmlink.orchestration.written.expression import Expression

_ROUNDING = 1e-9

_NAME = re.compile(r"[\w.\[\]]+")
"""A plain name, which is no expression, whether or not there is such a variable."""


def with_sums(rig: Rig, texts: Iterable[str], where: str) -> Rig:
    """The same rig with those of some texts that are expressions as variables of their own.

    InputError if one is no weighted sum of outputs with one unit; `where` the text stands is put before it.
    """
    sums = {
        text: _sum(rig, text, f"{where}.{text}")
        for text in dict.fromkeys(texts)
        if text not in rig.variables and not _NAME.fullmatch(text)
    }
    return replace(rig, sums={**rig.sums, **sums}) if sums else rig


def _sum(rig: Rig, text: str, where: str) -> WeightedSum:
    expression = Expression(text, where)
    scalars = {name: rig.scalar(name, where) for name in expression.variables}
    if not scalars:
        raise InputError(f"{where}: names no variable of {rig.name}; write one as INSTANCE.VARIABLE")
    if driven := [name for name, each in scalars.items() if each.start is not None]:
        raise InputError(
            f"{where}: a sum is made of outputs, and has {listed(driven)}; a column that drives "
            "the machine in another quantity feeds a [term.NAME] with inputs of its own"
        )
    units = dict.fromkeys(each.variable.unit for each in scalars.values())
    if len(units) > 1:
        raise InputError(f"{where}: adds {listed(units)}; add outputs of one unit")
    weights = {name: weight for name, weight in expression.weights().items() if weight}
    (unit,), whole = units, sum(weights.values())
    first = next(iter(scalars.values()))
    shown = first.variable.display
    if first.is_temperature:
        if min(abs(whole), abs(whole - 1)) > _ROUNDING:
            raise InputError(
                f"{where}: the weights of its temperatures add up to {whole:g}; they add up to 0 in a "
                "difference, and to 1 in a mean"
            )
        shown = shown if abs(whole - 1) < _ROUNDING else None
    output = Output(text, unit, f"{text}, as a column has it", display=shown)
    return WeightedSum(weights, Scalar(0, text, output, 0))
