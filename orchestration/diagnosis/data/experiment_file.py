"""The file of an experiment (TOML), as it is written: a class for each of its tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from warmlink.fmus.errors import InputError
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.text_files import shown
from warmlink.orchestration.written.entries import Flag, OneOf, Quantity, Setting, Text, Value, Values
from warmlink.orchestration.written.tables import Table

PER_RUN = "run"

NOMINAL, MEASURED = "nominal", "measured"
"""What the states start from: the declared start values, or the first minute of measurements."""


class Label(Setting):
    """The value of a label: a text, or a number that is taken for one."""

    def _read(self, value: Any) -> str:
        if not isinstance(value, str | int | float):
            raise InputError(f"{shown(value)} is not a name; write it as text")
        return str(value)

    def _schema(self) -> dict[str, Any]:
        return {"type": ["string", "number", "boolean"], "examples": ["shiny"]}


@dataclass(frozen=True)
class RunTable(Table):
    """One run: its measurements, and what holds for it alone."""

    data: Annotated[str, Text("FILE.csv")]
    labels: Mapping[str, Annotated[str, Label()]] = field(default_factory=dict)
    heldout: Annotated[bool, Flag()] = False
    adapt: Annotated[float, Quantity("s", least=0)] = 0.0
    known: Values = field(default_factory=dict)


@dataclass(frozen=True)
class CalibrateTable(Table):
    """Between which bounds a variable is fitted in every model; `per` a label, or "run"."""

    min: Annotated[str | float, Value()]
    max: Annotated[str | float, Value()]
    start: Annotated[str | float | None, Value()] = None
    per: Annotated[str | None, Text(PER_RUN)] = None


@dataclass(frozen=True)
class CausesTable(Table):
    """A file of causes of one's own, and by which labels the parameters of a cause may differ."""

    per: tuple[Annotated[str, Text("LABEL")], ...] = ()
    file: Annotated[str | None, Text("causes.toml")] = None
    shipped: Annotated[bool, Flag()] = True


@dataclass(frozen=True)
class TermTable(Table):
    """Heat that the model lacks, by an expression; numbers without a unit are in SI units.

    A column may drive its `inputs`, under `NAME.INPUT`; they are given with what they are without a column.
    """

    heat: Annotated[str, Text("a * max(speed - b, 0)**1.5")]
    into: Annotated[str, Text("shaft")]
    parameters: Values = field(default_factory=dict)
    inputs: Values = field(default_factory=dict)


@dataclass(frozen=True)
class ExperimentFile(Table):
    """An experiment: the runs on one system, what is known, and what is calibrated."""

    system: Annotated[str, Text(DEFAULT)]
    run: tuple[RunTable, ...]
    title: Annotated[str | None, Text()] = None
    initial: Annotated[str, OneOf((NOMINAL, MEASURED))] = NOMINAL
    channels: Mapping[str, Annotated[str, Text("link.elongation")]] = field(default_factory=dict)
    covariates: Mapping[str, Annotated[str, Text("neighbour_temperature")]] = field(default_factory=dict)
    known: Values = field(default_factory=dict)
    calibrate: Mapping[str, CalibrateTable] = field(default_factory=dict)
    causes: CausesTable = field(default_factory=CausesTable)
    term: Mapping[str, TermTable] = field(default_factory=dict)
    noise: Values = field(default_factory=dict)
    accuracy: Values = field(default_factory=dict)
    in_loop: Annotated[bool, Flag()] = False

    def __post_init__(self) -> None:
        if not self.run:
            raise InputError('there is no [[run]]; give at least one with data = "FILE.csv"')
