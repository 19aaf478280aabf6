"""Pages of the reference, made from the code: commands, files, components, causes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from extension.texts import ROOT, adapted, component_pages


def pages() -> dict[str, str]:
    """Text of each page by its name."""
    return {
        "commands": commands(),
        "causes": causes(),
        "names": names(),
        "variables": variables(),
        **formats(),
        **components(),
    }


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
        text += [f"{_options_as_code(command.help.strip())}\n"]
        records = (option.get_help_record(context) for option in command.params)
        rows = ((f"`{record[0]}`", _options_as_code(record[1])) for record in records if record)
        text += [markdown_table(("argument or option", "meaning"), rows)]
    return "\n".join(text)


def _options_as_code(text: str) -> str:
    """A help text with its options set as code, so that no line breaks after their dashes."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"(?<![\w-])--[a-z][a-z-]*", r"`\g<0>`", part) for part in parts[::2]]
    return "`".join(parts)


def formats() -> dict[str, str]:
    """A page for each kind of file that people write, from its JSON Schema."""
    from warmlink.orchestration.command_line.init import KINDS, TEMPLATES, kinds
    from warmlink.orchestration.written.tables import json_schema

    found = {}
    for kind, table in kinds().items():
        schema = json_schema(table)
        text = [f"# {kind.capitalize()} file (TOML)\n", f"{schema['description']}\n", f"{_FORMATS_TEXT}\n"]
        text += [f"`warmlink schema {kind}` prints this as a JSON Schema.\n"]
        for headings, shape in _tables(schema):
            required = shape.get("required", [])
            rows = (_entry(*each, required) for each in shape["properties"].items())
            text += [f"## {headings}\n", markdown_table(HEADS, rows)]
        for made in (each for each in (kind, *_ALSO.get(kind, ())) if each in KINDS):
            example = (TEMPLATES / f"{made}.toml").read_text("utf-8")
            text += [f"## Example: {made}\n", f"`warmlink init {made}` writes this file.\n"]
            text += [f"```toml\n{example}```\n"]
        found[f"files/{kind}"] = "\n".join(text)
    return found


HEADS = ("entry", "meaning", "type", "unit or range", "default", "example")

_ALSO = {"scenario": ("cell",)}
"""Examples of a kind of file besides the one of its name."""

_FORMATS_TEXT = 'A value with a unit is a text, `"20 min"`; a bare number is in the SI unit.'


def _tables(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The file itself and each kind of table in it, under the headings that it has in files."""
    definitions = schema.get("$defs", {})
    used: dict[str, list[str]] = {name: [] for name in definitions}
    for shape in (schema, *definitions.values()):
        for key, entry in shape["properties"].items():
            for name in {each for each in definitions if f"#/$defs/{each}" in _refs(entry)}:
                used[name].append(_heading(key, entry))
    yield "Entries", schema
    for name, table in definitions.items():
        yield ", ".join(dict.fromkeys(used[name])), table


def _refs(shape: dict[str, Any]) -> set[str]:
    """What an entry refers to, itself or for each of its items."""
    inner = (shape, shape.get("items"), shape.get("additionalProperties"))
    return {each["$ref"] for each in inner if isinstance(each, dict) and "$ref" in each}


def _heading(name: str, shape: dict[str, Any]) -> str:
    """How the tables of an entry are headed in a file."""
    if "$ref" in shape:
        return f"`[{name}]`"
    return f"`[[{name}]]`" if "items" in shape else f"`[{name}.NAME]`"


def _entry(name: str, shape: dict[str, Any], required: list[str]) -> tuple[str, ...]:
    default = "required" if name in required else _default(shape)
    if _refs(shape):
        many = "list of tables" if "items" in shape else "a table for each name"
        kind, example = "table" if "$ref" in shape else many, _heading(name, shape)
    else:
        kind, example = _type(shape), f"`{name} = {_written(_example(shape))}`"
    return f"`{name}`", shape["title"], kind, _bounds(shape), default, example


def _default(shape: dict[str, Any]) -> str:
    default = shape.get("default")
    if default in (None, "", [], {}):
        return "none"
    return "as in its table" if isinstance(default, dict) else f"`{_written(default)}`"


def _type(shape: dict[str, Any]) -> str:
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


def _example(shape: dict[str, Any]) -> Any:
    if "examples" in shape:
        return shape["examples"][0]
    return [_example(shape["items"])] if "items" in shape else shape["enum"][0]


def _written(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_written(each)}" for key, each in value.items()) + " }"
    return json.dumps(value, ensure_ascii=False)


def _key(name: str) -> str:
    return name if name.isidentifier() else json.dumps(name)


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
        found[page] = adapted(ROOT / readme).replace(MARK, f"```{{raw}} html\n{tables}\n```")
    listed = "\n".join(page.partition("/")[2] for page in found)
    found["components/index"] = f"# Components\n\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n"
    return found


def variables() -> str:
    """Every variable of the components once, with its unit and where it is."""
    from warmlink.fmus.catalogue import catalogue

    found: dict[tuple[str, str, str], list[str]] = {}
    for component in (entry.component for entry in catalogue()):
        for each in (*component.inputs, *component.parameters, *component.outputs):
            found.setdefault((each.name, each.unit, each.description), []).append(component.name)
    rows = (
        (f"`{name}`", f"`{unit}`" if unit != "1" else "", about, ", ".join(where))
        for (name, unit, about), where in sorted(found.items())
    )
    text = "# Variables and units\n\nSI inside. Symbols of equations stand in the components' own pages.\n\n"
    return text + markdown_table(("variable", "unit", "what it is", "components"), rows)


def causes() -> str:
    """The catalogue of causes."""
    from warmlink.orchestration.diagnosis.causes.catalogue import catalogue

    rows = (
        (f"`{each.name}`", each.sentence, each.looks_like, each.check, " ".join(f"`{v}`" for v in each.frees))
        for each in catalogue()
    )
    heads = ("cause", "what happens", "what it looks like", "what to check on the machine", "frees")
    return "# Causes\n\nWhat a diagnosis looks for.\n\n" + markdown_table(heads, rows)


def names() -> str:
    """What `warmlink list` prints."""
    from warmlink.orchestration.command_line.init import _descriptions

    text = ["# Names\n", "The names that the commands accept, as `warmlink list` prints them.\n"]
    for kind, entries in _descriptions().items():
        rows = ((f"`{name}`", about) for name, about in entries.items())
        text += [f"## {kind.capitalize()}\n", markdown_table(("name", "what it is"), rows)]
    return "\n".join(text)


def markdown_table(heads: tuple[str, ...], rows: Any) -> str:
    """Rows as a table in Markdown."""
    lines = [heads, tuple("---" for _ in heads), *rows]
    return "\n".join(f"| {' | '.join(_cell(each) for each in line)} |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
