"""The kinds of variables that a component declares, and how they lie in one flat vector."""

from collections import namedtuple
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from keyword import iskeyword
from types import SimpleNamespace
from typing import Any, Literal

from warmlink.fmus.component.arithmetic import Number, stack

NOMINAL_TEMPERATURE = 300.0
"""K, by which tolerances on temperatures are scaled."""

VariableType = Literal["Real", "Integer", "Boolean"]

Record = Any
"""Named values, one attribute a variable: a number, or a vector where the variable has a size."""

Values = Mapping[str, Number]
"""The same by name."""


def is_difference(variable: "Variable") -> bool:
    """Whether a variable in K is a difference of temperatures, to which no unit's zero applies."""
    return variable.unit == "K" and variable.display is None and variable.nominal != NOMINAL_TEMPERATURE


@dataclass(frozen=True)
class Named:
    """Anything with a name and a unit: one number, or `size` of them."""

    name: str
    unit: str
    size: int | None = field(default=None, kw_only=True)

    @property
    def count(self) -> int:
        """Number of scalars."""
        return 1 if self.size is None else self.size

    @property
    def scalar_names(self) -> list[str]:
        """Names of the scalars: `heat_flow`, or `position[1]` to `position[8]`."""
        if self.size is None:
            return [self.name]
        return [f"{self.name}[{i}]" for i in range(1, self.size + 1)]


@dataclass(frozen=True)
class Choice:
    """An enumeration: the type's name, as `PadMode`, and those of its values 0, 1, 2 and so on."""

    name: str
    items: tuple[str, ...]

    last = property(lambda self: len(self.items) - 1)
    """Largest value."""


@dataclass(frozen=True)
class Band:
    """Lowest and highest value at which a model still describes the thing, and why it is mostly left."""

    low: float
    high: float
    why: str = ""

    @property
    def far(self) -> tuple[float, float]:
        """Bounds beyond which a value means nothing: twice the band's width away from it."""
        width = self.high - self.low
        return self.low - FAR * width, self.high + FAR * width


FAR = 2.0
"""Widths of its band by which a value that means nothing lies outside."""


@dataclass(frozen=True)
class Variable(Named):
    """Base class of inputs, parameters and outputs.

    Attributes
    ----------
    unit : SI unit in Modelica's notation, as `W/(m2.K)`; "1" for a pure number
    display : unit in which people read it, as `degC` or `um`; None where it is the unit itself
    nominal : size of an ordinary value, by which tolerances are scaled
    minimum, maximum : bounds that the value may reach
    plausible : values at which the model describes the thing; looked at after a run, never inside an FMU
    choice : names of the values of an Integer that chooses among a few; its type and bounds follow
    """

    display: str | None = field(default=None, kw_only=True)
    nominal: float | None = field(default=None, kw_only=True)
    minimum: float | None = field(default=None, kw_only=True)
    maximum: float | None = field(default=None, kw_only=True)
    plausible: Band | None = field(default=None, kw_only=True)
    type: VariableType = field(default="Real", kw_only=True)
    choice: Choice | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.choice is not None:
            bounds = {} if isinstance(self, Output) else {"minimum": 0, "maximum": self.choice.last}
            for name, value in {"type": "Integer", **bounds}.items():
                object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Input(Variable):
    """A variable that the master sets; `accepts_nan` for one that copes with a missing value."""

    description: str
    start: float = field(default=0.0, kw_only=True)
    accepts_nan: bool = field(default=False, kw_only=True)
    discrete: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Parameter(Variable):
    """A value given before the run.

    Attributes
    ----------
    starts : start values of a vector whose elements differ
    positive : the value must lie above 0, which it may not reach
    tunable : may change between communication steps; acts from the next sample or micro step on, and on the
        outputs that depend on it at once
    rare : it is 0 unless somebody wants what it brings; while all rare parameters are 0, the step in C leaves
        that out
    """

    start: float
    description: str
    starts: tuple[float, ...] | None = field(default=None, kw_only=True)
    positive: bool = field(default=False, kw_only=True)
    tunable: bool = field(default=False, kw_only=True)
    rare: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Output(Variable):
    """A variable that the component computes."""

    description: str
    discrete: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Local(Output):
    """A variable that shows the inside of a component, for whoever looks: a heat flow between two states."""


@dataclass(frozen=True)
class State(Named):
    """A state of a component; `start` is a number or the name of a parameter.

    Its value is always finite; it may be NaN only if `accepts_nan` is set. A state that is `slow` is made
    with `arithmetic.accumulated`: an export in single precision carries on what rounding leaves of it.
    """

    start: float | str = field(default=0.0, kw_only=True)
    accepts_nan: bool = field(default=False, kw_only=True)
    slow: bool = field(default=False, kw_only=True)


@dataclass(frozen=True)
class Derived(Named):
    """A quantity that follows from the parameters alone; it is computed once before the run."""


@dataclass(frozen=True)
class Terminal:
    """Scalars that are connected together, as heat flow and temperature where two bodies touch.

    Terminals of one kind may be connected, member by member: its name, and that of the scalar that it is, as
    `("temperature", "base_temperature")`.
    """

    name: str
    kind: str
    members: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Scalar:
    """One scalar of the interface: its value reference, its name, its declaration and place in that."""

    reference: int
    name: str
    variable: Input | Parameter | Output
    element: int

    @property
    def start(self) -> float | None:
        """Start value; None for an output, which is computed."""
        if isinstance(self.variable, Output):
            return None
        if isinstance(self.variable, Parameter) and self.variable.starts is not None:
            return self.variable.starts[self.element]
        return self.variable.start

    @property
    def is_temperature(self) -> bool:
        """Whether it is a temperature, which has a zero (degC), rather than a difference of two (K)."""
        return self.variable.unit == "K" and not is_difference(self.variable)

    @property
    def is_discrete(self) -> bool:
        """Whether it is an input whose values are names, as 0 for off and 2 for held, without a mean."""
        return isinstance(self.variable, Input) and (self.variable.discrete or self.variable.type != "Real")

    @property
    def lower(self) -> float | None:
        """The bound that a model description states: the minimum, or 0 for a positive parameter."""
        positive = isinstance(self.variable, Parameter) and self.variable.positive
        return 0.0 if positive else self.variable.minimum


class Layout:
    """How named variables lie in one flat vector.

    Names with dots, as `link.conductivity`, are read as records within records, so that the part of a joined
    component finds its own values as if it stood alone: `values.link.conductivity`.
    """

    def __init__(self, variables: Sequence[Named]) -> None:
        self.variables = tuple(variables)
        self.names = [name for variable in self.variables for name in variable.scalar_names]
        self.size = len(self.names)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._places: dict[str, int | slice] = {}
        inner: dict[str, list[Named]] = {}
        start = 0
        for variable in self.variables:
            end = start + variable.count
            self._places[variable.name] = start if variable.size is None else slice(start, end)
            part, dot, rest = variable.name.partition(".")
            if dot:
                inner.setdefault(part, []).append(replace(variable, name=rest))
            start = end
        self._own = {name: place for name, place in self._places.items() if "." not in name}
        self._inner = {
            part: (Layout(held), _merged([self._places[f"{part}.{each.name}"] for each in held]))
            for part, held in inner.items()
        }
        fields: Any = list(self._own)
        fit = all(name.isidentifier() and name[0] != "_" and not iskeyword(name) for name in fields)
        self._record: Any = namedtuple("Values", fields) if fit and not inner else None

    def read(self, vector: Number) -> Record:
        """Named values of a flat vector of any arithmetic, shape (size,)."""
        if self._record is not None:
            return self._record._make([vector[place] for place in self._own.values()])
        values = {name: vector[place] for name, place in self._own.items()}
        values |= {part: layout.read(vector[place]) for part, (layout, place) in self._inner.items()}
        return SimpleNamespace(**values)

    def values(self, vector: Number) -> dict[str, Number]:
        """Values of a flat vector by the variables' names, shape (size,)."""
        return {name: vector[place] for name, place in self._places.items()}

    def record(self, values: Values) -> Record:
        """Record of named values, each a number or a vector, for a layout whose names have no dots."""
        return SimpleNamespace(**values) if self._record is None else self._record(**values)

    def flat(self, values: Values) -> Number:
        """Flat vector of named values, shape (size,).

        KeyError: a variable is missing, or one is named that is not declared.
        """
        if values.keys() != self._places.keys():
            missing = [name for name in self._places if name not in values]
            unknown = [name for name in values if name not in self._places]
            raise KeyError(f"missing: {missing}, not declared: {unknown}")
        return stack(*(values[v.name] for v in self.variables))


def _merged(places: Sequence[int | slice]) -> slice | list[int]:
    """One place that holds several in their order: a slice where they adjoin."""
    each = [i for p in places for i in (range(p.start, p.stop) if isinstance(p, slice) else (p,))]
    adjoin = each and all(b == a + 1 for a, b in pairwise(each))
    return slice(each[0], each[-1] + 1) if adjoin else each


def split_name(name: str) -> tuple[str, str]:
    """Part and own name of a scalar of the whole."""
    variable, bracket, element = name.partition("[")
    key, _, own = variable.rpartition(".")
    return key, own + bracket + element
