"""What a server's values are: a file that says which of them stands under which header."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from warmlink.fmus.errors import InputError
from warmlink.orchestration.text_files import read_toml
from warmlink.orchestration.written.entries import Text
from warmlink.orchestration.written.tables import Table, read_table


@dataclass(frozen=True)
class SourceMapping(Table):
    """Values of a server by header: a path in JSON as `motor.temperature`, or a node of OPC UA."""

    columns: Mapping[str, Annotated[str, Text("motor.temperature")]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.columns:
            raise InputError('there are no [columns]; give "tip_temperature [degC]" = "motor.temperature"')


def read_mapping(path: Path) -> Mapping[str, str]:
    """Values of a server by header, in the order of the file; raises InputError where it does not fit."""
    remedy = "give a TOML file with [columns]"
    return read_table(SourceMapping, read_toml(path, remedy), path.name).columns
