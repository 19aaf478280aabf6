"""A controller of one's own: a class with a correction becomes a component like any shipped law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from warmlink.controllers.interface import INPUTS, OUTPUTS, SAMPLE_TIME, TOLERANCE
from warmlink.controllers.verdict import ready
from warmlink.fmus.component import Component, Parameter, Record, State
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.errors import InputError


class Law:
    """Base class of a controller: subclass it, declare parameters and states, and give a correction.

    The methods get records: states `x`, inputs `u` (`warmlink.controllers.interface.INPUTS`), parameters `p`,
    each value under its name, all SI. They are plain arithmetic with the functions of
    `warmlink.fmus.component.arithmetic`, `where` instead of `if`, so that the same lines become C. What the
    law remembers is a State: the object itself keeps nothing, since an FMU's state is saved and restored.

    Attributes
    ----------
    parameters : beside `sample_time` and `tolerance`, which every law has
    states : what the law remembers from sample to sample
    """

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    states: ClassVar[tuple[State, ...]] = ()

    def correction(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """What the tool point is moved back by, in m."""
        raise NotImplementedError

    def correction_std(self, x: Record, u: Record, p: Record, time: Number) -> Number:
        """Standard deviation of the correction's error in m; unless overridden, half the tolerance."""
        return 0.5 * p.tolerance

    def update(self, x: Record, u: Record, p: Record, time: Number, step: Number) -> Mapping[str, Number]:
        """Next value of every state by name, `step` seconds after the last."""
        raise NotImplementedError

    def begin(self, u: Record, p: Record) -> Mapping[str, Number]:
        """Start value of every state by name; unless overridden, the states' own `start`."""
        raise NotImplementedError

    def __setattr__(self, name: str, value: Any) -> None:
        raise InputError(
            f"{type(self).__name__}.{name}: a law's object keeps nothing; declare a State and give its next "
            "value in update"
        )


def component_of(law: type[Law]) -> Component:
    """The component that a law's class describes, with the connectors of every compensator.

    Raises
    ------
    InputError
        The class gives no correction, or has states and no update.
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
