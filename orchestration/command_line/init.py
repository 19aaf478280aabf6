"""`warmlink init` and `schema`: a commented file to begin with, and what a kind of file may contain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.command_line.options import Argument, Option
from warmlink.orchestration.console import answer, answer_json

TEMPLATES = Path(__file__).parent / "templates"


def init(
    kind: Annotated[
        str, Argument(help="Kind: `scenario`, `cell`, `study`, `law`, `experiment` or `causes`.")
    ],
    out: Annotated[Path, Option(help="Folder to write into.")] = Path(),
) -> None:
    """Write a commented example file to begin with, and the data files that it names; it runs as it is.

    Example: `warmlink init experiment --out rig`, then `warmlink diagnose rig/experiment.toml`
    """
    from warmlink.orchestration.files import fresh_folder

    if kind not in KINDS:
        raise InputError(f"{kind}: no such kind of file; {instead(kind, KINDS)}")
    for name in KINDS[kind]:
        if (out / name).exists():
            raise InputError(f"{out / name}: exists already; remove it, or choose another --out")
    with fresh_folder(out) as work:
        for name, write in KINDS[kind].items():
            write(work / name)
    answer("\n".join(str(out / name) for name in KINDS[kind]))
    answer(f"try  {NEXT[kind]} {out / next(iter(KINDS[kind]))}{':MyLaw' if kind == 'law' else ''}")


def _template(path: Path) -> None:
    # A law's template is no module of this package.
    kept = path.with_suffix(".txt") if path.suffix == ".py" else path
    path.write_bytes((TEMPLATES / kept.name).read_bytes())


def _schema(path: Path) -> None:
    import json

    from warmlink.orchestration.scenarios.written import json_schema

    path.write_text(json.dumps(json_schema(kinds()[path.stem]), indent=2) + "\n", encoding="utf-8")


def _run(path: Path) -> None:
    """Write a made-up run in which still air cools more than nominally; two columns are renamed."""
    from warmlink.orchestration.diagnosis.practice import hide as made_up

    columns = made_up.hide({"still_air_convection": 1.3}, seed=len(path.stem))
    named = {"base_temperature [degC]": "T_base [degC]", "tip_temperature [degC]": "T_tip [degC]"}
    made_up.write_csv({named.get(name, name): values for name, values in columns.items()}, path)


CAUSES: dict[str, Callable[[Path], None]] = {"causes.toml": _template, "causes.json": _schema}

KINDS: dict[str, dict[str, Callable[[Path], None]]] = {
    "scenario": {"scenario.toml": _template, "scenario.json": _schema},
    "cell": {"cell.toml": _template, "scenario.json": _schema},
    "study": {"study.toml": _template, "study.json": _schema},
    "law": {"law.py": _template},
    "experiment": {
        "experiment.toml": _template,
        "experiment.json": _schema,
        **CAUSES,
        "run.csv": _run,
        "check.csv": _run,
    },
    "causes": CAUSES,
}
"""Files of each kind, the first of them the commented one, and what writes each."""

NEXT = {
    "scenario": "warmlink run",
    "cell": "warmlink run",
    "study": "warmlink tune",
    "law": "warmlink run --controller",
    "experiment": "warmlink diagnose",
    "causes": "warmlink diagnose an experiment with [causes] file =",
}
"""Command that takes the commented file."""


def schema(
    kind: Annotated[str, Argument(help="Kind of file, such as `scenario` or `study`.")],
) -> None:
    """Print the JSON Schema of a kind of file, so that an editor can complete and check what you write.

    Kinds: `scenario`, `program` (a scenario of the six-axis arm), `duty`, `study`, `mismatch`,
    `experiment`, `causes`.
    Save the schema beside your file, and name it in the file's first line: `#:schema study.json`. Editors
    that use Taplo understand this line, for example VS Code with the extension Even Better TOML.

    Example: `warmlink schema study > study.json`
    """
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
