"""Small changes of Python code, each of which a test should notice: signs, numbers, conditions, returns."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

_COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    **{ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In},
}
_SIGNS: dict[type[ast.operator], type[ast.operator]] = {
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult},
}
_CHOICES: dict[type[ast.boolop], type[ast.boolop]] = {ast.And: ast.Or, ast.Or: ast.And}
Node = ast.expr | ast.stmt


@dataclass(frozen=True)
class Mutant:
    """A change of a source: what stood in a line, and what stands there now."""

    line: int
    before: str
    after: str
    source: str

    def __str__(self) -> str:
        return f"`{_short(self.before)}` became `{_short(self.after)}`"


def mutants(source: str) -> list[Mutant]:
    """Every change of a source, in the order of its lines.

    Left alone are annotations, decorators, texts, what only a type checker reads, and the `strict` of a zip.
    """
    code, found = source.encode(), []
    begins = [0, *accumulate(len(line) for line in code.splitlines(keepends=True))]
    for node in _changeable(ast.parse(source)):
        for old, after in _changes(node):
            start = begins[old.lineno - 1] + old.col_offset
            end = begins[(old.end_lineno or old.lineno) - 1] + (old.end_col_offset or 0)
            changed = code[:start] + after.encode() + code[end:]
            found.append(Mutant(old.lineno, code[start:end].decode(), after, changed.decode()))
    return sorted(found, key=lambda each: each.line)


def _changeable(tree: ast.AST) -> Iterator[Node]:
    """Nodes below another whose change may matter to somebody who runs the code."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or _without_effect(child):
                continue
            if isinstance(child, Node):
                yield child
            yield from _changeable(child)


def _without_effect(node: ast.AST) -> bool:
    """Whether it is a text, read by a type checker alone, or states that two things are of one length."""
    match node:
        case ast.If(ast.Name("TYPE_CHECKING")) | ast.keyword("strict") | ast.JoinedStr():
            return True
    return False


def _changes(node: Node) -> Iterator[tuple[Node, str]]:
    """What may be replaced at a node, and by what."""
    match node:
        case ast.Compare(left, [operator], right):
            yield node, _code(ast.Compare(left, [_COMPARED[type(operator)]()], right))
        case ast.BinOp(left, operator, right) if type(operator) in _SIGNS:
            if not (_is_text(left) or _is_text(right)):
                yield node, _code(ast.BinOp(left, _SIGNS[type(operator)](), right))
        case ast.BoolOp(operator, values):
            yield node, _code(ast.BoolOp(_CHOICES[type(operator)](), values))
        case ast.IfExp(test) | ast.If(test) | ast.While(test) if not isinstance(
            test, ast.Compare | ast.BoolOp
        ):
            yield test, _code(ast.UnaryOp(ast.Not(), test))
        case ast.Constant(bool(value)):
            yield node, str(not value)
        case ast.Constant(int(value)):
            yield node, str(value + 1)
        case ast.Constant(float(value)):
            yield node, repr(2 * value or 1.0)
        case ast.Return(value) if value is not None and not _is_none(value):
            yield node, "return None"
        case ast.Expr(ast.Call()) | ast.Raise() | ast.AugAssign() | ast.Continue() | ast.Break():
            yield node, "pass"


def _is_text(node: ast.expr | None) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _is_none(node: ast.expr | None) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _code(node: ast.expr) -> str:
    return f"({ast.unparse(ast.fix_missing_locations(node))})"


def _short(text: str, most: int = 60) -> str:
    plain = " ".join(text.split())
    return plain if len(plain) <= most else f"{plain[:most]}..."
