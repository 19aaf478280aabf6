"""A variable of a law's Python lends its name to the expression that it held."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from warmlink.controllers.export.program.algebra import told_by
from warmlink.controllers.export.program.expressions import Computed

_NOT_ITS_NAMES = ("arithmetic.py", "matrices.py", "calls.py", "instance.py")


def noticed(frame: Any, event: str, result: Any) -> None:
    """Name what the variables of a law's function hold, when it returns."""
    if event != "return":
        return
    if not _lends(frame.f_code.co_filename):
        return
    arguments = frame.f_code.co_varnames[: frame.f_code.co_argcount]
    for name, value in frame.f_locals.items():
        if name != "self" and not name.startswith("."):
            _named(value, name.strip("_"), "fallback" if name in arguments else "name")
    if isinstance(result, tuple):
        _named(result, frame.f_code.co_name.strip("_"), "fallback")


@cache
def _lends(file: str) -> bool:
    """Whether variables of the functions in a file lend their names; asked at every return."""
    path = Path(file)
    ours = path.parent.name == "program" or path.name in _NOT_ITS_NAMES
    return not (ours or path.name.startswith("<") or "numpy" in path.parts)


def _named(value: Any, name: str, kind: str, depth: int = 0) -> None:
    if isinstance(value, Computed):
        if value.kind != "constant" and not (value.kind == "leaf" and value.data[0] != "settled"):
            setattr(value, kind, getattr(value, kind) or name)
            if value.kind == "select" and told_by(value) is not None:
                _named(value.of[0], name, kind, depth)
    elif isinstance(value, dict) and depth < 2:
        for key, each in value.items():
            _named(each, str(key), "fallback", depth + 1)
    elif isinstance(value, (tuple, list)) and depth < 3 and len(value) < 40:
        fields = getattr(value, "_fields", None)
        for i, each in enumerate(value):
            _named(each, fields[i] if fields else f"{name}_{i + 1}", kind, depth + 1)
