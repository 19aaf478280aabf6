"""The page inside an FMU: the component's README with a table of its variables."""

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import NamedTuple

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import MOST_IN_A_STEP, Component, Input, Output, Parameter
from warmlink.fmus.component.units import display_conversion
from warmlink.fmus.packaging import release

MARK = "<!-- variables -->"
"""Line of a README at which the tables of variables stand."""


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
    style = Path(__file__).with_suffix(".css").read_text("utf-8")
    release_of = f"{component.name}, warmlink {release.version()}. {release.COPYRIGHT}, {release.LICENSE}."
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(component.name)}</title>\n<style>\n{style}</style>\n</head>\n"
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
            names = ("Name", "Unit", *(() if computed else ("Start", "Range")), "Description")
            heads = "".join(f"<th>{name}</th>" for name in names)
            rows = "".join(f"<tr>{''.join(_cells(variable))}</tr>\n" for variable in variables)
            table = f"<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>"
            parts.append(f"<h3>{title}</h3>\n<table>\n{table}\n</table>\n")
    return "".join(parts)


def _longest_step(component: Component) -> str:
    parts, sampled = dict[str, str](), [clock.sample_time for clock in component.clocks]
    if sampled:
        parts["sample"] = sampled[0] if len(sampled) == 1 else "the shortest sample time"
    if component.continuous.size or not sampled:
        parts["micro step"] = f"{component.micro_step:g} s"
    longest = " or ".join(parts.values()) + (", whichever is shorter" if len(parts) > 1 else "")
    return (
        f"<p>One communication step lasts at most {MOST_IN_A_STEP} times {longest}. A tunable parameter may "
        f"change between communication steps; it acts from the next {' or '.join(parts)} on, and at once on "
        "the outputs that depend on it directly. A drift counts from where it began, also when its rate "
        "changes.</p>\n"
    )


class Facts(NamedTuple):
    """A variable as people read it; `start` and `bounds` are empty for what is computed."""

    name: str
    unit: str
    start: str
    bounds: str
    meaning: str


def facts(variable: Input | Parameter | Output) -> Facts:
    """Say of a variable what its user must know, in the unit in which people read it."""
    size = "" if variable.size is None else f"[1..{variable.size}]"
    unit = variable.display or ("" if variable.unit == "1" else variable.unit)
    name, unit = f"{variable.name}{size}", unit if variable.type == "Real" else variable.type
    if isinstance(variable, Output):
        return Facts(name, unit, "", "", variable.description)
    starts: tuple[float, ...] = (variable.start,)
    remark = ""
    limits = [("≥", variable.minimum), ("≤", variable.maximum)]
    if isinstance(variable, Parameter):
        starts = variable.starts or starts
        limits[0] = (">", 0.0) if variable.positive else limits[0]
        remark = "; tunable" if variable.tunable else ""
    elif variable.accepts_nan:
        remark = "; may be NaN"
    bounds = [f"{sign} {_shown(variable, limit)}" for sign, limit in limits if limit is not None]
    shown = [_shown(variable, start) for start in starts]
    while len(shown) > 2 and shown[-1] == shown[-2]:
        shown.pop()
    more = " …" * (len(shown) < len(starts))
    return Facts(name, unit, ", ".join(shown) + more, ", ".join(bounds), f"{variable.description}{remark}")


def _cells(variable: Input | Parameter | Output) -> Iterator[str]:
    told = facts(variable)
    yield f"<td><code>{escape(told.name)}</code></td>"
    yield f"<td>{escape(told.unit)}</td>"
    if not isinstance(variable, Output):
        yield f'<td class="number">{told.start}</td>'
        yield f'<td class="number">{escape(told.bounds)}</td>'
    yield f"<td>{escape(told.meaning)}</td>"


def _shown(variable: Input | Parameter | Output, value: float) -> str:
    if variable.type == "Boolean":
        return "true" if value else "false"
    if variable.display is not None:
        factor, offset = display_conversion(variable.unit, variable.display)
        value = factor * value + offset
    return f"{value:.10g}"
