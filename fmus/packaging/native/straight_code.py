"""CasADi's functions of plain numbers as C that compilers make much of.

CasADi writes a choice as a sum of two, each result behind a test whether it is asked for, and what a call
takes and gives as two arrays of pointers. Here a choice is one expression, which becomes one or two
instructions; what is given and what is found are said not to overlap; and single numbers are handed over as
numbers.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from warmlink.fmus.calls import in_a_loop

_WHOLE = re.compile(
    r"(/\* (\w+:\(\S*\)->\(\S*\)) \*/\n)"
    r"static int (casadi_f\d+)(\(const casadi_real\*\* arg.*?\)) \{\n.*?\n\}\n",
    re.DOTALL,
)
"""A function as CasADi writes it, below its name and the sizes of what it takes and gives."""

_CALL = re.compile(
    r"((?:  arg1\[\d+\]=.*;\n)*)((?:  res1\[\d+\]=.*;\n)*)"
    r"  if \((casadi_f\d+)\(arg1, res1, iw, w, 0\)\) return 1;\n"
)
"""A call as CasADi writes it."""

_LEFT_OUT = re.compile(r"  res1\[\d+\]=0;\n(?:  res1\[\d+\]=.*;\n)* +if \((casadi_f\d+)\(")
"""A call that gives no place for one of the results."""

_FUNCTION = re.compile(r"^static int (casadi_f\d+)\(.*?^\}\n", re.DOTALL | re.MULTILINE)

_HELPER = re.compile(
    r"^(?:casadi_real|void) (casadi_\w+)\([^{]*\{(?:[^\n]+\}\n|\n.*?^\}\n)", re.DOTALL | re.MULTILINE
)
"""One of CasADi's own helpers."""

_Operation = tuple[int, list[int], str]
"""CasADi's number of an operation, what it is made of, and how it is written."""


def with_straight_code(text: str, functions: Iterable[Any]) -> str:
    """C as CasADi writes it for functions, with the functions of plain numbers among them written anew.

    A function stays as it is where some call does not want all its results: it must ask for each whether it
    is wanted.
    """
    known = _by_description(functions)
    in_part = wanted_in_part(text)
    written: dict[str, _Written] = {}

    def anew(found: re.Match[str]) -> str:
        above, described, name, parameters = found.groups()
        function = known.get(described)
        if function is None or name in in_part or not _writable(function):
            return found[0]
        code = _Written.of(function, name)
        written[name] = code
        return f"{above}{code.text}static int {name}{parameters} {{\n{code.entry}}}\n"

    def direct(found: re.Match[str]) -> str:
        if found[3] not in written:
            return found[0]
        given, taken = (re.findall(r"=(.*);", part) for part in found.groups()[:2])
        return f"  {written[found[3]].call(given, taken)};\n"

    text = _CALL.sub(direct, _WHOLE.sub(anew, text))
    named = Counter(re.findall(r"casadi_f\d+(?=\()", text))

    def used(found: re.Match[str]) -> str:
        idle = found[1] in written and named[found[1]] == 1
        return "" if idle else _without_idle_variables(found[0])

    return _without_idle_helpers(_FUNCTION.sub(used, text))


def wanted_in_part(text: str) -> set[str]:
    """Names of the functions that some call gives no place for one of their results."""
    return set(_LEFT_OUT.findall(text))


def _by_description(functions: Iterable[Any]) -> dict[str, Any]:
    """Functions of plain numbers by name and sizes, but for those that share these with any other."""
    found: dict[str, dict[int, Any]] = {}
    for each in _all(functions):
        found.setdefault(str(each).rpartition(" ")[0], {})[each.__hash__()] = each
    alone = {described: next(iter(those.values())) for described, those in found.items() if len(those) == 1}
    return {described: function for described, function in alone.items() if function.is_a("SXFunction")}


def _all(functions: Iterable[Any]) -> Iterator[Any]:
    """Functions and those that they call."""
    for function in functions:
        yield function
        yield from _all(function.find_functions(0))


def _without_idle_variables(function: str) -> str:
    """A function without variables that nothing uses any more."""
    named = Counter(re.findall(r"\w+", function))

    def declared(line: re.Match[str]) -> str:
        kept = [each for each in line[2].split(", ") if named[re.findall(r"\w+", each)[0]] > 1]
        return f"  {line[1]} {', '.join(kept)};\n" if kept else ""

    return re.sub(r"^  ((?:const )?casadi_real) ([^(;]*);\n", declared, function, flags=re.MULTILINE)


def _without_idle_helpers(text: str) -> str:
    """C without those of CasADi's helpers that nothing calls any more."""
    while True:
        named = Counter(re.findall(r"\bcasadi_\w+\b(?! CASADI_PREFIX)", text))
        idle = [found[0] for found in _HELPER.finditer(text) if named[found[1]] == 1]
        if not idle:
            return text
        for each in idle:
            text = text.replace(each, "")


@cache
def _forms() -> dict[int, str]:
    """How an operation is written, by its number."""
    import casadi

    binary = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "LT": "<", "LE": "<=", "EQ": "==", "NE": "!="}
    binary |= {"AND": "&&", "OR": "||"}
    forms = {name: f"({{0}}{sign}{{1}})" for name, sign in binary.items()}
    one = "SQRT", "EXP", "LOG", "SIN", "COS", "TAN", "TANH", "ATAN", "ERF", "FABS", "FLOOR", "CEIL"
    forms |= {name: f"{name.lower()}({{0}})" for name in one}
    forms |= {name: f"{name.lower()}({{0}},{{1}})" for name in ("POW", "FMOD", "ATAN2")}
    forms |= {name: f"casadi_{name.lower()}({{0}},{{1}})" for name in ("FMIN", "FMAX")}
    forms |= {"NEG": "(-{0})", "NOT": "(!{0})", "SQ": "({0}*{0})", "TWICE": "({0}+{0})", "INV": "(1./{0})"}
    forms |= {"SIGN": "casadi_sign({0})", "IF_ELSE_ZERO": "({0}?{1}:0)"}
    return {getattr(casadi, f"OP_{name}"): form for name, form in forms.items()}


def _writable(function: Any) -> bool:
    import casadi

    moved = {casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST}
    kinds = {function.instruction_id(k) for k in range(function.n_instructions())}
    return kinds <= moved | _forms().keys()


@dataclass(frozen=True)
class _Written:
    """A function written anew.

    Attributes
    ----------
    name, text : of it
    alone : for each argument whether it is a single number
    results : how many vectors it finds
    """

    name: str
    text: str
    alone: tuple[bool, ...]
    results: int

    @classmethod
    def of(cls, function: Any, name: str) -> "_Written":
        """Write a function; its name is that of CasADi's with `_of` behind."""
        alone = tuple(function.nnz_in(k) == 1 for k in range(function.n_in()))
        loop = in_a_loop(function)
        one, paired = loop or (function, [False] * len(alone))
        body = "".join(f"  {line}\n" for line in _lines(one, alone, paired, loop is not None))
        if loop:
            body = f"  casadi_int i;\n  for (i=0; i<2; ++i) {{\n{body}  }}\n"
        parameters = [
            f"casadi_real x{k}" if one else f"const casadi_real *restrict x{k}" for k, one in enumerate(alone)
        ]
        parameters += [f"casadi_real *restrict y{k}" for k in range(function.n_out())]
        unused = [f"(void)x{k};" for k in range(len(alone)) if not re.search(rf"\bx{k}\b", body)]
        body = "".join(f"  {each}\n" for each in unused) + body
        text = f"static void {name}_of({', '.join(parameters)}) {{\n{body}}}\n"
        return cls(f"{name}_of", text, alone, function.n_out())

    @property
    def entry(self) -> str:
        """Body of a function that is called as CasADi's are."""
        given, taken = (
            [f"{kind}[{k}]" for k in range(n)]
            for kind, n in (("arg", len(self.alone)), ("res", self.results))
        )
        return f"  {self.call(given, taken)};\n  return 0;\n"

    def call(self, given: list[str], taken: list[str]) -> str:
        """A call with pointers."""
        numbers = [number_at(each) if alone else each for each, alone in zip(given, self.alone, strict=True)]
        return f"{self.name}({', '.join([*numbers, *taken])})"


def number_at(pointer: str) -> str:
    """The number that an expression points at."""
    own = re.fullmatch(r"\(&(\w+)\)", pointer)
    return own[1] if own else f"*({pointer})"


def _lines(function: Any, alone: tuple[bool, ...], paired: Sequence[bool], loops: bool) -> list[str]:
    """One line for each operation that any result needs, in CasADi's order.

    Parameters
    ----------
    alone, paired : for each argument whether it is a single number, and whether it holds two side by side
    loops : whether the lines are those of a loop over two side by side
    """
    import casadi

    def place(index: int, pairs: bool) -> str:
        return f"[{2 * index}+i]" if pairs else f"[{index}]"

    held: dict[int, int] = {}  # which operation's result a place of CasADi's holds
    made: list[_Operation] = []
    operation: _Operation
    for k in range(function.n_instructions()):
        kind, given, taken = (
            getattr(function, f"instruction_{what}")(k) for what in ("id", "input", "output")
        )
        if kind == casadi.OP_CONST:
            operation = kind, [], _constant(function.instruction_constant(k))
        elif kind == casadi.OP_INPUT:
            which = given[0]
            operation = kind, [], f"x{which}" + ("" if alone[which] else place(given[1], paired[which]))
        elif kind == casadi.OP_OUTPUT:
            operation = kind, [held[given[0]]], f"y{taken[0]}{place(taken[1], loops)}"
        else:
            operation = kind, [held[each] for each in given], _forms()[kind]
            operation = _choice(made, *operation)
        if kind != casadi.OP_OUTPUT:
            held[taken[0]] = k
        made.append(operation)
    needed: set[int] = set()
    lines = []
    for k in reversed(range(len(made))):
        kind, parts, form = made[k]
        names = [f"a{part}" for part in parts]
        if kind == casadi.OP_OUTPUT:
            lines.append(f"{form}={names[0]};")
        elif k in needed:
            lines.append(f"const casadi_real a{k}={form.format(*names)};")
        else:
            continue
        needed.update(parts)
    return lines[::-1]


def _choice(made: list[_Operation], kind: int, parts: list[int], form: str) -> _Operation:
    """An operation, or where it adds what holds under a condition to what holds otherwise, that choice."""
    import casadi

    if kind == casadi.OP_ADD and all(made[part][0] == casadi.OP_IF_ELSE_ZERO for part in parts):
        (one, then), (other, otherwise) = (made[part][1] for part in parts)
        if made[other][0] == casadi.OP_NOT and made[other][1] == [one]:
            return kind, [one, then, otherwise], "({0}?{1}:{2})"
        if made[one][0] == casadi.OP_NOT and made[one][1] == [other]:
            return kind, [other, otherwise, then], "({0}?{1}:{2})"
    return kind, parts, form


def _constant(value: float) -> str:
    """A number with a point."""
    mantissa, e, exponent = repr(value).partition("e")
    if "n" in mantissa:
        return {"nan": "casadi_nan", "inf": "casadi_inf", "-inf": "-casadi_inf"}[mantissa]
    return (mantissa if "." in mantissa else f"{mantissa}.") + e + exponent
