"""Pages of the reference, made from the code: commands, files, components, causes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from extension.texts import ROOT, adapted, component_pages


def pages() -> dict[str, str]:
    """Text of each page by its name."""
    return {"commands": commands(), "causes": causes(), "names": names(), **formats(), **components()}


def commands() -> str:
    """Every command with its arguments and options, from its help."""
    import typer

    from warmlink.orchestration.cli import application

    group: Any = typer.main.get_command(application())
    whole = group.context_class(group, info_name="warmlink")
    text = ["# Commands\n", "Each command explains itself: `warmlink COMMAND --help`.\n"]
    for name, command in group.commands.items():
        context = command.context_class(command, info_name=name, parent=whole)
        text += [f"## warmlink {name}\n", f"```text\n{command.get_usage(context)}\n```\n"]
        text += [f"{command.help.strip()}\n"]
        records = (option.get_help_record(context) for option in command.params)
        rows = ((f"`{record[0]}`", record[1]) for record in records if record)
        text += [_table(("argument or option", "meaning"), rows)]
    return "\n".join(text)


def formats() -> dict[str, str]:
    """A page for each kind of file that people write, from its JSON Schema."""
    from warmlink.orchestration.command_line.init import KINDS, TEMPLATES
    from warmlink.orchestration.command_line.schema import kinds
    from warmlink.orchestration.scenarios.written import json_schema

    found = {}
    for kind, table in kinds().items():
        schema = json_schema(table)
        text = [f"# {kind.capitalize()} file (TOML)\n", f"{schema['description']}\n", f"{_FORMATS_TEXT}\n"]
        text += [f"`warmlink schema {kind}` prints this as a JSON Schema.\n"]
        for title, shape in _tables(schema):
            required = shape.get("required", [])
            rows = (_entry(*each, required) for each in shape["properties"].items())
            text += [f"## {title}\n", _table(_HEADS, rows)]
        if kind in KINDS:
            example = (TEMPLATES / f"{kind}.toml").read_text("utf-8")
            text += [
                "## Example\n",
                f"`warmlink init {kind}` writes this file.\n",
                f"```toml\n{example}```\n",
            ]
        found[f"files/{kind}"] = "\n".join(text)
    return found


_HEADS = ("entry", "type", "unit or range", "default", "example")

_FORMATS_TEXT = 'A value with a unit is a text, `"20 min"`; a bare number is in the SI unit.'


def _tables(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The file itself and each kind of table in it, with a title."""
    yield "Entries", schema
    for definition, table in schema.get("$defs", {}).items():
        if "properties" in table:
            yield f"Entries of {_called(definition)}", table


def _called(definition: str) -> str:
    return f"a `{definition.removesuffix('Table').removesuffix('Settings').lower()}` table"


def _entry(name: str, shape: dict[str, Any], required: list[str]) -> tuple[str, ...]:
    default = "required" if name in required else _default(shape)
    return f"`{name}`", _type(shape), _bounds(shape), default, _example(name, shape)


def _default(shape: dict[str, Any]) -> str:
    default = shape.get("default")
    if default in (None, [], {}):
        return "none"
    return "as in its table" if isinstance(default, dict) else f"`{_written(default)}`"


def _type(shape: dict[str, Any]) -> str:
    if "$ref" in shape:
        return _called(shape["$ref"].rpartition("/")[2])
    if "enum" in shape:
        return "one of " + ", ".join(f"`{each}`" for each in shape["enum"])
    if "items" in shape and "string" not in shape["type"]:
        return f"list of: {_type(shape['items'])}"
    if isinstance(shape.get("additionalProperties"), dict):
        return f"table; under each name: {_type(shape['additionalProperties'])}"
    kinds = shape["type"] if isinstance(shape["type"], list) else [shape["type"]]
    words = {
        "string": "text",
        "integer": "whole number",
        "boolean": "true or false",
        "array": "list of texts",
    }
    return " or ".join(words.get(kind, kind) for kind in kinds)


def _bounds(shape: dict[str, Any]) -> str:
    if shape.get("description"):
        return str(shape["description"])
    for inner in ("items", "additionalProperties"):
        if isinstance(shape.get(inner), dict):
            return _bounds(shape[inner])
    words = {"exclusiveMinimum": "above", "minimum": "at least", "maximum": "at most"}
    return ", ".join(f"{word} {shape[key]:g}" for key, word in words.items() if key in shape)


def _example(name: str, shape: dict[str, Any]) -> str:
    if "$ref" in shape:
        return f"`[{name}]`"
    if "items" in shape and "$ref" in shape["items"]:
        return f"`[[{name}]]`"
    if "examples" in shape:
        return f"`{name} = {_written(shape['examples'][0])}`"
    for inner, written in (("items", "{} = [{}]"), ("additionalProperties", '{} = {{ "NAME" = {} }}')):
        if isinstance(shape.get(inner), dict):
            each = shape[inner].get("examples")
            return f"`{written.format(name, _written(each[0]))}`" if each else f"`[{name}.NAME]`"
    if "enum" in shape:
        return f"`{name} = {_written(shape['enum'][0])}`"
    return ""


def _written(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def components() -> dict[str, str]:
    """README of every component, with the tables of its variables."""
    from warmlink.fmus.catalogue import catalogue
    from warmlink.fmus.packaging.documentation import MARK, variable_tables

    known = component_pages()
    found = {}
    for entry in catalogue():
        page = f"components/{entry.component.name}"
        tables = variable_tables(entry.component).replace("<table>", '<table class="docutils">')
        readme = next(path for path, name in known.items() if name == page and path.suffix)
        found[page] = adapted(ROOT / readme, page, known).replace(MARK, f"```{{raw}} html\n{tables}\n```")
    listed = "\n".join(page.partition("/")[2] for page in found)
    found["components/index"] = f"# Components\n\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n"
    return found


def causes() -> str:
    """The catalogue of causes."""
    from warmlink.orchestration.diagnosis.causes.catalogue import catalogue

    rows = (
        (f"`{each.name}`", each.sentence, each.looks_like, each.check, " ".join(f"`{v}`" for v in each.frees))
        for each in catalogue()
    )
    heads = ("cause", "what happens", "what it looks like", "what to check on the machine", "frees")
    return "# Causes\n\nWhat a diagnosis looks for.\n\n" + _table(heads, rows)


def names() -> str:
    """What `warmlink list` prints."""
    from warmlink.orchestration.command_line.list import _descriptions

    text = ["# Names\n", "The names that the commands accept, as `warmlink list` prints them.\n"]
    for kind, entries in _descriptions().items():
        rows = ((f"`{name}`", about) for name, about in entries.items())
        text += [f"## {kind.capitalize()}\n", _table(("name", "what it is"), rows)]
    return "\n".join(text)


def _table(heads: tuple[str, ...], rows: Any) -> str:
    lines = [heads, tuple("---" for _ in heads), *rows]
    return "\n".join(f"| {' | '.join(_cell(each) for each in line)} |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
