"""A user's own controller: a class that computes a correction becomes a component like a shipped law."""

from collections.abc import Mapping
from typing import Any, ClassVar

from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, TOLERANCE, ready
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
    """

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    states: ClassVar[tuple[State, ...]] = ()

    def correction(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Distance in m by which the tool point is to be moved back; every law must define it."""
        raise NotImplementedError

    def correction_std(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Standard deviation of the correction's error in m; half the tolerance unless the law defines it."""
        return 0.5 * p.tolerance

    def update(self, x: Record, u: Record, p: Record, time: Number, step: Number) -> Mapping[str, Number]:
        """Next value of every state by name, `step` seconds after the last; needed if the law has states."""
        raise NotImplementedError

    def begin(self, u: Record, p: Record) -> Mapping[str, Number]:
        """Start value of every state by name; without this method, states begin at their `start`."""
        raise NotImplementedError

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
    if law.states and law.update is Law.update:
        raise InputError(f"{name}: has states, but no update; define update(self, x, u, p, time, step)")

    def observe(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
        correction = given.correction(x, u, p, time)
        std = given.correction_std(x, u, p, time)
        return {
            **{output.name: 0.0 for output in OUTPUTS},
            "correction": correction,
            "predicted_elongation": correction,
            "correction_std": std,
            "ready": ready(std, p.tolerance),
        }

    return Component(
        name=name,
        description=(law.__doc__ or name).strip().partition("\n")[0].rstrip("."),
        inputs=INPUTS,
        parameters=(SAMPLE_TIME, TOLERANCE, *law.parameters),
        states=law.states,
        outputs=OUTPUTS,
        observe=observe,
        update=given.update if law.states else None,
        begin=None if law.begin is Law.begin else given.begin,
    )
