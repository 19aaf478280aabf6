"""What a component is: its declaration, and what follows from it without any FMI."""

from warmlink.fmus.component.declaration import (
    FIELD,
    MOST_IN_A_STEP,
    SHORTEST_SAMPLE_TIME,
    Check,
    Clock,
    Component,
    Joint,
)
from warmlink.fmus.component.layout import Layout, Record
from warmlink.fmus.component.variables import (
    Choice,
    Derived,
    Input,
    Local,
    Output,
    Parameter,
    Scalar,
    State,
    Terminal,
    Variable,
    VariableType,
)

__all__ = [
    "FIELD",
    "MOST_IN_A_STEP",
    "SHORTEST_SAMPLE_TIME",
    "Check",
    "Choice",
    "Clock",
    "Component",
    "Derived",
    "Input",
    "Joint",
    "Layout",
    "Local",
    "Output",
    "Parameter",
    "Record",
    "Scalar",
    "State",
    "Terminal",
    "Variable",
    "VariableType",
]
