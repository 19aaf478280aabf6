"""A system of co-simulation components, and what is known of their FMUs before these are loaded.

A system is the one form that every SSP is read into and that the master runs. Nested systems are
flattened on reading; a component then bears its full dotted name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import Answer
from warmlink.orchestration.system.units import Unit

CONNECTOR_KINDS = (
    "input",
    "output",
    "parameter",
    "calculatedParameter",
    "structuralParameter",
    "local",
    "constant",
)
ConnectorType = Literal["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"]
Value = float | int | bool | str
StartValues = Mapping[str, Mapping[str, Value]]
"""Start values by instance and variable."""

INTEGER_RANGES = {
    "Integer": (-(1 << 31), (1 << 31) - 1),
    **{f"Int{bits}": (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
}
"""Least and largest value of each integer type of FMI."""

TYPES: dict[str, ConnectorType] = {
    **dict.fromkeys(("Real", "Float32", "Float64"), "Real"),
    **dict.fromkeys(INTEGER_RANGES, "Integer"),
    "Boolean": "Boolean",
    "String": "String",
    "Enumeration": "Enumeration",
    "Binary": "Binary",
}
"""Those of connectors by the words of FMI 2.0, FMI 3.0 and SSP."""


@dataclass(frozen=True)
class Connector:
    """A connector as written: `type` is SSP's name of it, None where none is given; `sizes` of an array."""

    kind: str
    type: str | None = None
    unit: Unit | None = None
    sizes: tuple[int, ...] = ()


SspVersion = Literal["1.0", "2.0"]
Implementation = Literal["any", "CoSimulation", "ModelExchange"]
"""Interface of an FMU that a system uses, in SSP's words; `any` is co-simulation where the FMU offers it."""


@dataclass(frozen=True)
class FmuPart:
    """One FMU in the system: its file, connectors by name, start values in its variables' own units."""

    name: str
    fmu: Path
    connectors: Mapping[str, Connector] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    implementation: Implementation = "any"


@dataclass(frozen=True)
class Connection:
    """From an output to an input: `target = factor * source + offset` in the two variables' own units.

    `values` that are no Reals become others, an Enumeration's by their integers; those without an entry stay.
    """

    source_component: str
    source_variable: str
    target_component: str
    target_variable: str
    factor: float = 1.0
    offset: float = 0.0
    values: tuple[tuple[Value, Value], ...] = ()

    @property
    def ends(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Names of component and variable at the giving and at the taking end."""
        giving = self.source_component, self.source_variable
        return giving, (self.target_component, self.target_variable)

    @property
    def source(self) -> str:
        """Both names of the giving end, as `link.elongation`."""
        return f"{self.source_component}.{self.source_variable}"

    @property
    def target(self) -> str:
        """Both names of the taking end, as `camera.elongation`."""
        return f"{self.target_component}.{self.target_variable}"


@dataclass(frozen=True)
class DefaultExperiment:
    """Times in s and relative tolerance that a system or an FMU proposes; None if it proposes nothing."""

    start_time: float = 0.0
    stop_time: float | None = None
    step_size: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True, repr=False)
class System(Answer):
    """Components by name, in the order given, and the connections between them.

    The `remarks` are sentences on what the standard lets a reader pass over.
    """

    name: str
    components: dict[str, FmuPart]
    connections: tuple[Connection, ...] = ()
    default_experiment: DefaultExperiment = DefaultExperiment()
    remarks: tuple[str, ...] = ()

    def summary(self) -> str:
        """Name, components and number of connections."""
        return f"{self.name}: {', '.join(self.components)}; {len(self.connections)} connections"


@dataclass(frozen=True)
class ClockTicks:
    """When a clock of FMI 3.0 ticks.

    The `kind` is its intervalVariability; `interval` (None if the FMU tells it at run time) and `shift` are
    in s. Of clocks that tick at one time that of the least `priority` is first.
    """

    name: str
    kind: str
    interval: float | None = None
    shift: float = 0.0
    priority: int = 0


@dataclass(frozen=True)
class FmuVariable:
    """One scalar variable, an element of an array, or an array whose elements are too many to tell apart.

    Parameters
    ----------
    type : as the FMU writes it: `Real` in FMI 2.0, `Float64` in FMI 3.0, and so on
    kind : the type of connectors; None for those that cannot be connected (Clock)
    causality, variability, initial : with the standard's defaults; `initial` is None where none applies
    start, min, max, nominal : in `unit`, which may be of the declared type; an Enumeration's is its integer,
        a Binary's text of two hexadecimal digits for each byte
    relative : whether the value is a difference, to which unit offsets do not apply
    items : names of an Enumeration's items with their integers
    dimensions : sizes of an array that is not taken apart; empty for all others
    element, elements : place in an array, counted from 0 row by row, of so many elements, which have one
        value reference, and are exchanged together
    negated : whether what is exchanged by its value reference is the value times -1 (FMI 1.0)
    clock : when it ticks; None for what is no clock
    """

    name: str
    value_reference: int
    type: str
    kind: ConnectorType | None
    causality: str
    variability: str
    initial: str | None = None
    unit: str | None = None
    start: Value | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    relative: bool = False
    description: str = ""
    items: dict[str, int] = field(default_factory=dict)
    dimensions: tuple[int, ...] = ()
    element: int = 0
    elements: int = 1
    negated: bool = False
    clock: ClockTicks | None = None

    @property
    def settable(self) -> bool:
        """Whether a start value may be set before initialization (FMI 2.0 section 2.2.7, FMI 3.0 2.4.7.4)."""
        return self.variability != "constant" and self.initial in ("exact", "approx")


@dataclass(frozen=True)
class Capabilities:
    """What an FMU says it can do as one of its interfaces; False where its FMI version has no such flag.

    The `internal_step` in s, of which steps are multiples, is None if it tells none.
    """

    variable_step: bool = False
    get_set_state: bool = False
    serialize_state: bool = False
    directional_derivatives: bool = False
    interpolate_inputs: bool = False
    once_per_process: bool = False
    intermediate_update: bool = False
    event_mode: bool = False
    internal_step: float | None = None


@dataclass(frozen=True)
class ModelInfo:
    """An FMU's description, as a master and a checker need it.

    Parameters
    ----------
    fmi_version : `1.0`, `2.0` or `3.0`, whatever the minor version
    guid : FMI 2.0 `guid` or FMI 3.0 `instantiationToken`
    variables : by name, in the FMU's order, aliases too; elements of arrays are called `A[1,2]`
    arrays : names of the elements by the name of their array
    outputs : names, in the order of ModelStructure
    dependencies : for each output the names it depends on; None where the FMU declares nothing: all
    accepts_nan : inputs for which NaN is a proper value, as our own FMUs declare it
    remarks : sentences on what is wrong with the file, but can be passed over
    interface : what `model_identifier` and `capabilities` belong to; co-simulation where the FMU offers it
    exchange : both for model exchange, where the FMU offers that beside co-simulation
    continuous_states, event_indicators : how many a model for model exchange has
    """

    path: Path
    fmi_version: str
    model_name: str
    model_identifier: str
    guid: str
    description: str
    variables: dict[str, FmuVariable]
    outputs: tuple[str, ...]
    dependencies: dict[str, tuple[str, ...] | None]
    capabilities: Capabilities
    default_experiment: DefaultExperiment
    units: dict[str, Unit]
    arrays: dict[str, tuple[str, ...]] = field(default_factory=dict)
    log_categories: tuple[str, ...] = ()
    accepts_nan: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
    interface: Literal["CoSimulation", "ModelExchange", "ScheduledExecution"] = "CoSimulation"
    exchange: tuple[str, Capabilities] | None = None
    continuous_states: int = 0
    event_indicators: int = 0

    def used_as(self, implementation: Implementation) -> ModelInfo:
        """Give the description for the use of an interface; InputError if the FMU does not offer it."""
        if implementation in ("any", self.interface):
            return self
        if implementation == "CoSimulation" or self.exchange is None:
            told = f"{self.path.name}: offers {self.interface}, not {implementation}"
            raise InputError(f"{told}; export the model for it, or leave the choice to the master (any)")
        identifier, capabilities = self.exchange
        return replace(
            self,
            model_identifier=identifier,
            capabilities=capabilities,
            interface="ModelExchange",
            exchange=None,
        )

    @property
    def own_step(self) -> float | None:
        """Step in s that the FMU proposes and does not want to be changed; None if it takes any."""
        step = self.default_experiment.step_size or self.capabilities.internal_step
        return None if self.capabilities.variable_step else step

    def with_causality(self, causality: str) -> tuple[str, ...]:
        """Give the names of the variables of one causality, in the FMU's order."""
        return tuple(v.name for v in self.variables.values() if v.causality == causality)

    def feedthrough(self, output: str) -> frozenset[str]:
        """Give the inputs on which an output directly depends; all of them where nothing is declared."""
        inputs = frozenset(self.with_causality("input"))
        declared = self.dependencies.get(output)
        return inputs if declared is None else inputs.intersection(declared)
