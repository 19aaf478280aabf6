"""`warmlink init`: write a commented file to begin with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import answer

TEMPLATES = Path(__file__).parent / "templates"


def init(
    kind: Annotated[
        str, typer.Argument(help="Kind: `scenario`, `cell`, `study`, `law`, `experiment` or `causes`.")
    ],
    out: Annotated[Path, typer.Option(help="Folder to write into.")] = Path(),
) -> None:
    """Write a commented example file to begin with, and the data files that it names; it runs as it is.

    Example: `warmlink init experiment --out rig`, then `warmlink diagnose rig/experiment.toml`
    """
    from warmlink.fmus.names import instead
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

    from warmlink.orchestration.command_line.schema import kinds
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
