"""Values with units as people write them, in SI as the equations take them.

A temperature that has a zero (degC) and a difference of temperatures (K) are kept apart: whether a
variable is the one or the other is read from its declaration.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from warmlink.fmus.component import Input
from warmlink.orchestration.scenarios.quantity import quantity

if TYPE_CHECKING:
    from warmlink.fmus.component import Scalar


def is_temperature(scalar: Scalar) -> bool:
    """Whether a variable in K is a temperature rather than a difference of two."""
    return scalar.variable.unit == "K" and scalar.variable.display == "degC"


def is_discrete(scalar: Scalar) -> bool:
    """Whether the values of an input are names, as 0 for off and 2 for held, of which there is no mean."""
    variable = scalar.variable
    return isinstance(variable, Input) and (variable.discrete or variable.type != "Real")


def to_si(text: str | float, scalar: Scalar, where: str, difference: bool = False) -> float:
    """SI value of `"6 W"` or `"22 degC"` for a variable; a bare number is taken for SI.

    Parameters
    ----------
    text : a number, or a number and a unit
    scalar : declaration of the variable that takes it
    where : what to name in an error
    difference : whether it is a difference (a noise, an offset) even where the variable is a temperature

    Raises
    ------
    InputError
        Not a quantity, or one of another kind.
    """
    return quantity(
        text,
        scalar.variable.unit,
        where,
        difference=difference or not is_temperature(scalar),
    )
