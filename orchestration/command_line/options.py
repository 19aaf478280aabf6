"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, for machines.")]

Set = Annotated[
    list[str] | None,
    typer.Option("--set", help='Another start value, as --set "motor.joint_conductance=2 W/K". Repeatable.'),
]
Parameters = Annotated[
    list[Path] | None,
    typer.Option(help="A parameter set (SSV) of `design`, `tune` or `diagnose`. Repeatable."),
]
