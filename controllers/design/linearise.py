"""A component as a linear state space, by complex step through its own equations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warmlink.fmus.arguments import argument
from warmlink.fmus.component import Component, limits
from warmlink.fmus.component.integrator import COMPLEX_STEP
from warmlink.fmus.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    import control

Array = NDArray[np.float64]


def python_control() -> ModuleType:
    """The module `control`; MissingExtraError if it is not installed."""
    try:
        import control
    except ImportError:
        raise MissingExtraError("a linear model (python-control)", "studies") from None
    return control


@dataclass(frozen=True)
class Point:
    """Where a component is linearised.

    Attributes
    ----------
    x : all states, shape (x.size,)
    u : inputs, shape (u.size,)
    p : parameters, shape (p.size,)
    time : s
    """

    x: Array
    u: Array
    p: Array
    time: float = 0.0


def start(component: Component, given: Mapping[str, float] | None = None) -> Point:
    """Where a component begins, with the named parameters and inputs in place of their start values.

    Raises
    ------
    InputError
        A name is unknown or a parameter out of range.
    """
    p, u = limits.checked(component, "", given or {})
    x = np.asarray(component.states_at_start(u, component.settled(p)), dtype=float)
    return Point(x, u, p)


def slopes(function: Callable[..., Array], component: Component, at: Point, names: Sequence[str]) -> Array:
    """Derivative of a component's rates or outputs by states, inputs or parameters.

    Parameters
    ----------
    function : the component's `rates_of` or `outputs_of`, of m values
    component : the declaration
    at : where
    names : by what; a state's name is taken before a parameter's

    Returns
    -------
    numpy.ndarray
        Shape (m, len(names)).

    Raises
    ------
    InputError
        If a name is none of the component's.
    """
    unchanged = component.settled(at.p.astype(np.complex128))
    columns = []
    for name in names:
        x, u, p = (vector.astype(np.complex128) for vector in (at.x, at.u, at.p))
        for layout, vector in ((component.x, x), (component.u, u), (component.p, p)):
            if name in layout.index:
                vector[layout.index[name]] += 1j * COMPLEX_STEP
                break
        else:
            raise InputError(f"{component.name}: {name} is no state, input or parameter of it")
        settled = component.settled(p) if p.imag.any() else unchanged
        columns.append(np.imag(function(x, u, settled, at.time)) / COMPLEX_STEP)
    return np.column_stack(columns)


def linearise(component: Component, at: Point | None = None) -> "control.StateSpace":
    """Linear state space of a component's continuous states, its signals named.

    Parameters
    ----------
    component : one that stands by itself or a joined one; what is sampled keeps its states
    at : default: where it begins

    Returns
    -------
    control.StateSpace
        dx/dt = A x + B u, y = C x + D u for deviations from `at`, in SI units. Names have an underscore for
        each dot (`link_elongation`), which python-control allows in no name.

    Raises
    ------
    InputError
        If it is no component.
    MissingExtraError
        If python-control is not installed.
    """
    control = python_control()
    if not isinstance(component, Component):
        raise InputError(f"{argument('component', component)}: is no component; give one, or a joined one")
    at = at or start(component)
    states, inputs = component.continuous.names, component.u.names
    return control.ss(
        *(
            slopes(function, component, at, names)
            for function in (component.rates_of, component.outputs_of)
            for names in (states, inputs)
        ),
        name=component.name,
        states=[name.replace(".", "_") for name in states],
        inputs=[name.replace(".", "_") for name in inputs],
        outputs=[name.replace(".", "_") for name in component.y.names],
    )
