"""A user's own controller: a class that computes a correction becomes a component like a shipped law."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from warmlink.controllers.interface import SAMPLE_TIME, compensator, law_outputs
from warmlink.fmus.component import Component, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.errors import InputError


class Law:
    """Base class of a controller: subclass it, declare parameters and states, and define `correction`.

    The methods receive records of the states `x`, the inputs `u` (`warmlink.controllers.interface.INPUTS`)
    and the parameters `p`; each value stands under its name, in SI units. The methods use plain arithmetic
    and the functions of `warmlink.fmus.component.arithmetic`, with `where` instead of `if`, so that the same
    lines can be translated to C. The law can remember values only in its states: an attribute of the object
    is refused, because it would be lost when an FMU's state is saved and restored.

    Attributes
    ----------
    parameters : parameters of the law, besides `sample_time` and `tolerance`, which every law has
    states : values that the law remembers from one sample to the next
    update : method `update(self, x, u, p, time, step)` of a law with states: the next value of every state by
        name, `step` seconds after the last
    begin : method `begin(self, u, p)` if any: the start value of every state by name; without it,
        states begin at their `start`
    """

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    states: ClassVar[tuple[State, ...]] = ()

    def correction(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Distance in m by which the tool point is to be moved back; every law must define it."""
        raise NotImplementedError

    def correction_std(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Standard deviation of the correction's error in m; half the tolerance unless the law defines it."""
        return 0.5 * p.tolerance

    def outputs(self, x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
        """Outputs of every law by name, which follow from the correction and its standard deviation."""
        return law_outputs(self.correction(x, u, p, time), self.correction_std(x, u, p, time), p)

    def __setattr__(self, name: str, value: Any) -> None:
        raise InputError(
            f"{type(self).__name__}.{name}: a law cannot remember attributes; declare a State and give its "
            "next value in update"
        )


def component_of(law: type[Law]) -> Component:
    """The component that a law's class describes, with the connectors of every compensator.

    Raises
    ------
    InputError
        If the class defines no `correction`, or has states but defines no `update`.
    """
    name, given = law.__name__, law()
    if law.correction is Law.correction:
        raise InputError(f"{name}: gives no correction; define correction(self, x, u, p, time)")
    if law.states and not hasattr(law, "update"):
        raise InputError(f"{name}: has states, but no update; define update(self, x, u, p, time, step)")
    about = (law.__doc__ or name).strip().partition("\n")[0].rstrip(".")
    made = compensator(name, about, given, law.parameters, law.states)
    return made if made.sampled else replace(made, parameters=(SAMPLE_TIME, *made.parameters))


def check_symbols(component: Component) -> None:
    """Compare the law in symbols, from which C is made, with the law in numbers; TypeError if they differ.

    Python's `math` functions turn a symbol into NaN without an error.
    """
    import casadi as ca
    import numpy as np

    p, u = component.start_values()
    u = 1.1 * u + 0.1
    d = component.settled(p)
    x = component.states_at_start(u, d)

    def both(x: Any, u: Any, d: Any) -> list[Any]:
        observed = component.outputs_of(x, u, d, 7.0)
        return [observed] if component.update is None else [observed, component.updated(x, u, d, 7.0, 1.0)]

    symbols = [ca.SX.sym(name, len(values)) for name, values in (("x", x), ("u", u), ("d", d))]
    function = ca.Function("law", symbols, [ca.vertcat(*both(*symbols))])
    in_symbols = np.asarray(function(x, u, d), dtype=float).ravel()
    in_numbers = np.concatenate([np.atleast_1d(np.asarray(part, dtype=float)) for part in both(x, u, d)])
    if not np.allclose(in_symbols, in_numbers, rtol=1e-9, atol=1e-12, equal_nan=True):
        raise TypeError("the law gives another result for symbols than for numbers")
