"""`warmlink init`, `schema` and `list`: files to begin with, what they may hold, and names that exist."""

from __future__ import annotations

from dataclasses import astuple
from pathlib import Path
from typing import Any

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import remembered
from warmlink.orchestration.command_line.arguments import loaded
from warmlink.orchestration.console import answer, answer_json, print_table
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.shell import command, quoted

COMMANDS = ("init", "schema", "list", "info")

WIDE = 200
"""Width in characters of a table where the output is not a terminal."""

TEMPLATES = Path(__file__).parent / "templates"


def init(kind: str, *, out: Path = Path()) -> None:
    """Write a commented example file to begin with, and the data files that it names; it runs as it is.

    Example: `warmlink init experiment --out rig`, then `warmlink diagnose rig/experiment.toml`

    Parameters
    ----------
    kind : Kind: `scenario`, `cell`, `study`, `law`, `experiment` or `causes`.
    out : Folder to write into.
    """
    if kind not in KINDS:
        raise InputError(f"{kind}: no such kind of file; {instead(kind, KINDS)}")
    begins, *names = KINDS[kind]
    paths = [out / name for name in names]
    with fresh_folder(out) as work:
        for path in paths:
            written = work / path.name
            WRITERS[path.suffix](written)
            if path.exists():
                # A cell's schema is a scenario's, which may lie there.
                same = path.suffix == ".json" and path.is_file()
                if not same or path.read_bytes() != written.read_bytes():
                    raise InputError(f"{path}: exists already; remove it, or choose another --out")
                written.unlink()
    answer("\n".join(map(str, paths)))
    answer(f"try  {begins} {quoted(paths[0])}{':MyLaw' if kind == 'law' else ''}")


def _template(path: Path) -> None:
    # A law's template is no module of this package.
    kept = path.with_suffix(".txt") if path.suffix == ".py" else path
    path.write_bytes((TEMPLATES / kept.name).read_bytes())


def _schema(path: Path) -> None:
    import json

    path.write_text(json.dumps(_schema_of(path.stem), indent=2) + "\n", encoding="utf-8")


def _schema_of(kind: str) -> dict[str, Any]:
    from warmlink.orchestration.written.tables import json_schema

    if kind not in _READ_INTO:
        raise InputError(f"{kind}: no such kind of file; {instead(kind, _READ_INTO)}")
    return json_schema(loaded(_READ_INTO[kind]))


def _run(path: Path) -> None:
    """Write a made-up run in which still air cools more than nominally; two columns are renamed."""
    from warmlink.orchestration.diagnosis.practice import hide as made_up

    columns = made_up.hide({"still_air_convection": 1.3}, seed=len(path.stem))
    named = {"base_temperature [degC]": "T_base [degC]", "tip_temperature [degC]": "T_tip [degC]"}
    made_up.write_csv({named.get(name, name): values for name, values in columns.items()}, path)


_CAUSES, _RUNS = ("causes.toml", "causes.json"), ("run.csv", "check.csv")
KINDS: dict[str, tuple[str, ...]] = {
    "scenario": ("warmlink run", "scenario.toml", "scenario.json"),
    "cell": ("warmlink run", "cell.toml", "scenario.json"),
    "study": ("warmlink tune", "study.toml", "study.json"),
    "law": ("warmlink run --controller", "law.py"),
    "experiment": ("warmlink diagnose", "experiment.toml", "experiment.json", *_CAUSES, *_RUNS),
    "causes": ("warmlink diagnose an experiment with [causes] file =", *_CAUSES),
}
"""For each kind the command that takes the commented file, that file, and those beside it."""

_READ_INTO = {
    "scenario": "closed_loop.load:ScenarioFile",
    "program": "arm.program:ProgramFile",
    "duty": "scenarios.duties.duty_files:DutyFile",
    "study": "studies.study:StudyFile",
    "mismatch": "scenarios.mismatch:MismatchFile",
    "experiment": "diagnosis.data.experiment_file:ExperimentFile",
    "causes": "diagnosis.causes.declared:CausesFile",
}
"""Where the class is that each kind of file is read into."""

WRITERS = {".toml": _template, ".py": _template, ".json": _schema, ".csv": _run}


def schema(kind: str) -> None:
    """Print the JSON Schema of a kind of file, so that an editor can complete and check what you write.

    Kinds: `scenario`, `program` (a scenario of the six-axis arm), `duty`, `study`, `mismatch`,
    `experiment`, `causes`.
    Save the schema beside your file, and name it in the file's first line: `#:schema study.json`. Editors
    that use Taplo understand this line, for example VS Code with the extension Even Better TOML.

    Example: `warmlink schema study > study.json`

    Parameters
    ----------
    kind : Kind of file, such as `scenario` or `study`.
    """
    answer_json(_schema_of(kind))


def kinds() -> dict[str, type[Any]]:
    """The class that each kind of file is read into."""
    return {kind: loaded(place) for kind, place in _READ_INTO.items()}


def list_(what: list[str] | None = None, *, variant: str | None = None, json: bool = False) -> None:
    """List what there is by name; of one thing, what can be set and read, with units, defaults and ranges.

    Without a name it lists the scenarios, controllers, systems, components, mismatches, studies, effects and
    masters.

    Examples: `warmlink list ThermalLink`, `warmlink list dist/WarmupCell.ssp`

    Parameters
    ----------
    what : A component, controller or system by name, or any .fmu or .ssp file. `interface COMPONENT`: what
        an FMU in place of a component may be asked for.
    """
    if what and len(what) == 1:
        _describe(what[0], variant, json)
        return
    if variant is not None:
        raise InputError(f"--variant {variant}: is for one SSP; name it")
    found = _interface(what) if what else _all_names()
    if json:
        answer_json(found)
        return
    for kind, entries in found.items():
        print_table(kind, (), entries.items())


def info(file: Path, *, variant: str | None = None, json: bool = False) -> None:
    """Say what an FMU or a system (SSP) is: versions, platforms, what it can do, its parts.

    Example: `warmlink info dist/WarmupCell.ssp`; `warmlink list FILE` says what can be set in it.

    Parameters
    ----------
    file : An .fmu or .ssp file from any tool.
    """
    from warmlink.orchestration.describe import describe

    if file.suffix.lower() not in (".fmu", ".ssp"):
        raise InputError(f"{file}: is neither FMU nor SSP; give a file that ends in .fmu or .ssp")
    found = describe(file, variant=variant)
    if json:
        answer_json({"name": found.name, "about": found.about, **found.facts})
        return
    print_table(f"{found.name}: {found.about}", (), found.facts.items())
    answer(f"what can be set  {command('warmlink', 'list', file)}")


def _describe(what: str, variant: str | None, json: bool) -> None:
    from warmlink.orchestration.describe import HEADINGS, describe

    found = describe(what, variant=variant)
    if json:
        answer_json(found.to_dict())
    else:
        print_table(f"{found.name}: {found.about}", HEADINGS, map(astuple, found.variables), width=WIDE)
        if "variants" in found.facts:
            answer(f"variants  {found.facts['variants']}")


def _interface(what: list[str]) -> dict[str, dict[str, str]]:
    """Inputs and outputs of a component with units: what an FMU in its place may be asked for."""
    from warmlink.orchestration.catalogue import components

    if len(what) != 2 or what[0] != "interface":
        raise InputError(f"list {' '.join(what)}: nothing to list; write `list interface ThermalLink`")
    chosen = components().get(what[1])
    if chosen is None:
        raise InputError(f"{what[1]}: no such component; {instead(what[1], components())}")
    return {
        kind: {f"{name} [{each.unit}]": each.description for each in variables for name in each.scalar_names}
        for kind, variables in (("inputs", chosen.inputs), ("outputs", chosen.outputs))
    }


def _all_names() -> dict[str, dict[str, str]]:
    """What `_descriptions` gives, which takes a second to find; other packages may change what they add."""
    from warmlink.fmus.plugins import installed

    return _descriptions() if installed() else remembered("names", (), _descriptions)


def _descriptions() -> dict[str, dict[str, str]]:
    """One line about each thing, by its kind and its name."""
    from warmlink.orchestration.catalogue import components, controllers
    from warmlink.orchestration.closed_loop.load import load_scenario, scenario_names
    from warmlink.orchestration.diagnosis.practice.effects import about_effects
    from warmlink.orchestration.machine.shipped import machines
    from warmlink.orchestration.master.algorithms.named import about, masters
    from warmlink.orchestration.scenarios import mismatch
    from warmlink.orchestration.studies import study

    return {
        "scenarios": {name: load_scenario(name).title for name in scenario_names()},
        "controllers": {name: law.description for name, law in controllers().items()},
        "systems": machines(),
        "components": {name: component.description for name, component in components().items()},
        "mismatches": {name: mismatch.load(name).about for name in mismatch.names()},
        "studies": {name: study.load_study(name).title for name in study.names()},
        "effects to hide": about_effects(),
        "masters": {name: about(name) for name in masters()},
    }
