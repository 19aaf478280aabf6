"""`warmlink schema`: print what a kind of file may contain, for editors that complete and check it."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer_json


def schema(
    kind: Annotated[str, typer.Argument(help="Kind of file, such as `scenario` or `study`.")],
) -> None:
    """Print the JSON Schema of a kind of file, so that an editor can complete and check what you write.

    Kinds: `scenario`, `program` (a scenario of the six-axis arm), `duty`, `study`, `mismatch`,
    `experiment`, `causes`.
    Save the schema beside your file, and name it in the file's first line: `#:schema study.json`. Editors
    that use Taplo understand this line, for example VS Code with the extension Even Better TOML.

    Example: `warmlink schema study > study.json`
    """
    from warmlink.fmus.names import instead
    from warmlink.orchestration.scenarios.written import json_schema

    tables = kinds()
    if kind not in tables:
        raise InputError(f"{kind}: no such kind of file; {instead(kind, tables)}")
    answer_json(json_schema(tables[kind]))


def kinds() -> dict[str, type[Any]]:
    """The class that each kind of file is read into."""
    from warmlink.orchestration.arm.program import ProgramFile
    from warmlink.orchestration.closed_loop.load import ScenarioFile
    from warmlink.orchestration.diagnosis.causes.declared import CausesFile
    from warmlink.orchestration.diagnosis.data.experiment_file import ExperimentFile
    from warmlink.orchestration.scenarios.duties.duty_files import DutyFile
    from warmlink.orchestration.scenarios.mismatch import MismatchFile
    from warmlink.orchestration.studies.study import StudyFile

    return {
        "scenario": ScenarioFile,
        "program": ProgramFile,
        "duty": DutyFile,
        "study": StudyFile,
        "mismatch": MismatchFile,
        "experiment": ExperimentFile,
        "causes": CausesFile,
    }
