"""The page inside an FMU: the component's README with a table of its variables."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import MOST_IN_A_STEP, Component, Input, Output, Parameter
from warmlink.fmus.component.units import display_conversion
from warmlink.fmus.packaging import release

MARK = "<!-- variables -->"
"""Line of a README at which the tables of variables stand."""

_STYLE = """
body { font: 16px/1.55 system-ui, sans-serif; color: #222; }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2, h3 { line-height: 1.25; color: #7a2f18; }
code, pre { font-family: ui-monospace, Consolas, monospace; font-size: 0.92em; background: #f6f3f0; }
code { padding: 0.1em 0.25em; border-radius: 3px; }
pre { padding: 0.8em 1em; overflow-x: auto; border-left: 3px solid #d9a58f; }
pre code { padding: 0; background: none; }
table { border-collapse: collapse; width: 100%; margin: 0.6rem 0 1.4rem; font-size: 0.92em; }
th, td { text-align: left; padding: 0.3em 0.7em; border-bottom: 1px solid #e4ddd8; vertical-align: top; }
th { background: #f6f3f0; }
td.number { text-align: right; white-space: nowrap; }
footer { margin-top: 3rem; padding-top: 0.6rem; border-top: 1px solid #e4ddd8; }
footer { font-size: 0.85em; color: #666; }
"""


def documentation_page(entry: Entry) -> bytes:
    """README of a component as one HTML page that needs no other file; the mark becomes the tables."""
    from markdown_it import MarkdownIt

    component = entry.component
    text = f"# {component.name}\n\n{component.description}\n\n{MARK}\n"
    if entry.readme.is_file():
        text = entry.readme.read_text(encoding="utf-8")
    if entry.remarks:
        text += f"\n\n{entry.remarks}\n"
    if MARK not in text:
        text += f"\n\n## Variables\n\n{MARK}\n"
    body = MarkdownIt("commonmark").enable("table").render(text)
    body = body.replace(MARK, variable_tables(component) + _longest_step(component))
    release_of = f"{component.name}, warmlink {release.version()}. {release.COPYRIGHT}, {release.LICENSE}."
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(component.name)}</title>\n<style>{_STYLE}</style>\n</head>\n"
        f"<body>\n{body}<footer>{escape(release_of)}</footer>\n</body>\n</html>\n"
    ).encode()


def variable_tables(component: Component) -> str:
    """HTML tables of inputs, parameters and outputs, in the units in which people read them."""
    groups = (
        ("Inputs", component.inputs),
        ("Parameters", component.parameters),
        ("Outputs", component.outputs),
        ("Local variables of the native FMU", component.local),
    )
    parts = []
    for title, variables in groups:
        if variables:
            computed = isinstance(variables[0], Output)
            heads = ("Name", "Unit", *(() if computed else ("Start", "Range")), "Description")
            parts.append(f"<h3>{title}</h3>\n<table>\n<thead><tr>")
            parts += [f"<th>{head}</th>" for head in heads]
            parts.append("</tr></thead>\n<tbody>\n")
            parts += [f"<tr>{''.join(_cells(variable))}</tr>\n" for variable in variables]
            parts.append("</tbody>\n</table>\n")
    return "".join(parts)


def _longest_step(component: Component) -> str:
    parts = "sample_time" if component.sampled else f"{component.micro_step:g} s"
    acts = "sample" if component.sampled else "micro step"
    return (
        f"<p>One communication step lasts at most {MOST_IN_A_STEP} times {parts}. A tunable parameter may "
        f"change between communication steps; it acts from the next {acts} on, and at once on the outputs "
        "that depend on it directly. A drift counts from where it began, also when its rate changes.</p>\n"
    )


def _cells(variable: Input | Parameter | Output) -> Iterator[str]:
    size = "" if variable.size is None else f"[1..{variable.size}]"
    yield f"<td><code>{escape(variable.name)}{size}</code></td>"
    yield f"<td>{escape(_unit(variable))}</td>"
    if not isinstance(variable, Output):
        yield f'<td class="number">{escape(_starts(variable))}</td>'
        yield f'<td class="number">{escape(_range(variable))}</td>'
    remark = "; may be NaN" if isinstance(variable, Input) and variable.accepts_nan else ""
    if isinstance(variable, Parameter) and variable.tunable:
        remark = "; tunable"
    yield f"<td>{escape(variable.description)}{remark}</td>"


def _unit(variable: Input | Parameter | Output) -> str:
    if variable.type != "Real":
        return variable.type
    return variable.display or ("" if variable.unit == "1" else variable.unit)


def _starts(variable: Input | Parameter) -> str:
    if isinstance(variable, Parameter) and variable.starts is not None:
        return ", ".join(_shown(variable, value) for value in variable.starts)
    return _shown(variable, variable.start)


def _range(variable: Input | Parameter) -> str:
    if isinstance(variable, Parameter) and variable.positive:
        above = f"> {_shown(variable, 0.0)}"
        return above if variable.maximum is None else f"{above}, ≤ {_shown(variable, variable.maximum)}"
    bounds = ((variable.minimum, "≥"), (variable.maximum, "≤"))
    return ", ".join(f"{sign} {_shown(variable, bound)}" for bound, sign in bounds if bound is not None)


def _shown(variable: Input | Parameter | Output, value: float) -> str:
    if variable.type == "Boolean":
        return "true" if value else "false"
    if variable.display is not None:
        factor, offset = display_conversion(variable.unit, variable.display)
        value = factor * value + offset
    return f"{value:.10g}"
