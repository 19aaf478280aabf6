"""CasADi's functions as C, written from their instructions: for numbers, or for vectors of several runs.

What is only moved is read where it lies, and an idle function leaves its arguments as they are by pointing at
them. A choice is one expression, which becomes one or two instructions; and what is given and what is found
are said not to overlap.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from itertools import accumulate, count
from pathlib import Path
from typing import Any

from warmlink.fmus.calls import IDLE, written
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.native.casadi_code import unsimplified

DECLARED = ("settle", "margins", "begin", "begin_tangent", "advance", "rates", "rates_tangent", "tangent")
"""Functions that `model.h` declares; others are for the generated file alone."""

_OF_ONE = (
    "sqrt exp expm1 log log1p erf fabs floor ceil sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh"
)
_OF_TWO = "pow fmod remainder atan2 hypot copysign fmin fmax"
"""Functions of C, which CasADi calls alike."""

_LANES = Path(__file__).parent / "sources" / "lanes.h"
"""Vectors and their functions, of so many `LANES`."""


def functions_text(functions: Iterable[Any], declared: Collection[str] = DECLARED, lanes: int = 0) -> str:
    """C functions from CasADi's, each as `void NAME(const double *x0, ..., double *y0)`.

    Parameters
    ----------
    functions : of numbers (SX), or of vectors and calls (MX)
    declared : names of those that a header declares under `WL(NAME)`; the others are static, as `NAME_of`
    lanes : where given, so many runs go side by side: in place of each double is a vector of gcc and clang,
        `lanes`, of which every element is computed as the number would be, in the same order
    """
    writer = _Writer(_dialect(lanes > 0))
    for each in functions:
        name = each.name()
        writer.write(f"void WL({name})" if name in declared else f"static void {name}_of", each)
    header = f"#define LANES {lanes}\n{_LANES.read_text('utf-8')}" if lanes else "#include <math.h>\n"
    return "\n".join([header, *writer.texts])


_PLACED = re.compile(r"(\w+)\[(\d+)\]")
"""A number that lies in a vector: in which, and where."""


def _dialect(lanes: bool) -> Mapping[str, str]:
    """Forms of C for numbers, or for the vectors of `lanes.h`: of operations, by CasADi's name, and more.

    Beside them the type of a number, a constant, a choice, and the question whether a condition holds.
    """
    asked = {"LT": "{0}<{1}", "LE": "{0}<={1}", "EQ": "{0}=={1}", "NE": "{0}!={1}"}
    asked |= {"NOT": "{0}==0.", "AND": "({0}!=0.)&({1}!=0.)", "OR": "({0}!=0.)|({1}!=0.)"}
    forms = {name: f"TRUTH({form})" if lanes else f"({form})" for name, form in asked.items()}
    forms |= {"ADD": "({0}+{1})", "SUB": "({0}-{1})", "MUL": "({0}*{1})", "DIV": "({0}/{1})"}
    forms |= {"NEG": "(-{0})", "SQ": "({0}*{0})", "TWICE": "({0}+{0})", "INV": "(1./{0})"}
    prefix = "lanes_" if lanes else ""
    forms |= {name.upper(): f"{prefix}{name}({{0}})" for name in _OF_ONE.split()}
    forms |= {name.upper(): f"{prefix}{name}({{0}},{{1}})" for name in _OF_TWO.split()}
    forms["CONSTPOW"] = forms["POW"]
    if lanes:
        forms |= {"type": "lanes", "constant": "EACH({0})", "choice": "EITHER({0},{1},{2})"}
        return forms | {"asked": "any_of({0})", "IF_ELSE_ZERO": "IF({0},{1})", "SIGN": "lanes_sign({0})"}
    forms |= {"type": "double", "constant": "{0}", "choice": "({0}?{1}:{2})", "asked": "{0}!=0"}
    return forms | {"IF_ELSE_ZERO": "({0}?{1}:0)", "SIGN": "({0}<0?-1:{0}>0?1:{0})"}


class _Writer:
    """C of functions, each of them once and after those that it calls."""

    def __init__(self, forms: Mapping[str, str]) -> None:
        import casadi

        self.forms, self.type = forms, forms["type"]
        self.operations = {getattr(casadi, name): name[3:] for name in dir(casadi) if name.startswith("OP_")}
        self.texts: list[str] = []
        self._names: dict[int, str] = {}

    def write(self, head: str, function: Any) -> None:
        """Write a function that takes and gives vectors."""
        whole, paired, _ = written(function)
        with unsimplified():
            numbers = whole.expand() if whole.is_a("MXFunction") else whole
        lines, used = _Body(self, numbers, paired).lines()
        if paired:
            lines = ["for (int i=0; i<2; ++i) {", *(f"  {line}" for line in lines), "}"]
        declared = {f"x{k}": f"const {self.type}" for k in range(function.n_in())}
        declared |= {f"y{k}": self.type for k in range(function.n_out())}
        lines = [f"(void){name};" for name in declared if name not in used] + lines
        parameters = (f"{kind} *restrict {name}" for name, kind in declared.items())
        text = "".join(f"  {line}\n" for line in lines)
        self.texts.append(f"{head}({', '.join(parameters)})\n{{\n{text}}}\n")

    def named(self, function: Any) -> str:
        """Name in C of a function that is called."""
        key = function.__hash__()
        if key not in self._names:
            self._names[key] = name = f"{function.name()}_{len(self._names)}"
            self.write(f"static void {name}", function)
        return self._names[key]


class _Body:
    """Statements of a function.

    Parameters
    ----------
    writer : writes the functions that this one calls
    function : of numbers, and of calls of such
    paired : how many of the first arguments hold two side by side; if any does, the statements are those of
        a loop over both, and so are the results
    """

    def __init__(self, writer: _Writer, function: Any, paired: int) -> None:
        self.writer, self.forms, self.type, self.name = writer, writer.forms, writer.type, function.name()
        self._statements: list[tuple[str, str]] = []
        """C, and the name of the number that it makes, if that is all it does."""
        self._made: dict[str, tuple[str, list[str]]] = {}  # by which operation, of what
        self._gathered: dict[str, str] = {}
        self._vectors = count()
        held: dict[int, str] = {}  # in CasADi's places
        nodes = function.instructions_sx()
        for k in range(function.n_instructions()):
            kind = writer.operations[function.instruction_id(k)]
            given, taken = function.instruction_input(k), function.instruction_output(k)
            if kind == "INPUT":
                held[taken[0]] = f"x{given[0]}[{_index(given[1], given[0] < paired)}]"
            elif kind == "CONST":
                held[taken[0]] = self._literal(function.instruction_constant(k))
            elif kind == "CALL":
                found = self._called(nodes.nz[k].which_function(), [held[place] for place in given])
                held |= zip(taken, found, strict=True)
            elif kind == "OUTPUT":
                self._add(f"y{taken[0]}[{_index(taken[1], paired > 0)}]={held[given[0]]};")
            else:
                held[taken[0]] = self._operation(kind, [held[place] for place in given])

    def lines(self) -> tuple[list[str], set[str]]:
        """Lines without the numbers that a choice has made needless, and the names that they use."""
        used, lines = set[str](), list[str]()
        for text, makes in reversed(self._statements):
            if not makes or makes in used:
                used.update(re.findall(r"\w+", text))
                lines.append(text)
        return lines[::-1], used

    def _add(self, text: str, makes: str = "") -> None:
        self._statements.append((text, makes))

    def _literal(self, value: float) -> str:
        """A number that is written out, with a point."""
        text = f"{value:#}".replace("inf", "(double)INFINITY").replace("nan", "(double)NAN")
        return self.forms["constant"].format(f"({text})" if text[0] == "-" else text)

    def _operation(self, kind: str, given: list[str]) -> str:
        """Result of an operation; what adds that under a condition to that otherwise is one choice."""
        form = self.forms.get(kind)
        if form is None:
            raise InputError(
                f"{self.name}: CasADi's operation {kind.lower()} has no C here; write it with others"
            )
        parts = [self._made.get(each, ("", [])) for each in given]
        if kind == "ADD" and all(made == "IF_ELSE_ZERO" for made, _ in parts):
            (one, then), (other, otherwise) = (each for _, each in parts)
            if self._made.get(other) == ("NOT", [one]):
                form, given = self.forms["choice"], [one, then, otherwise]
        found = f"a{len(self._statements)}"
        self._add(f"const {self.type} {found}={form.format(*given)};", found)
        self._made[found] = kind, given
        return found

    def _beside(self, numbers: list[str]) -> str:
        """Pointer to numbers that lie side by side, or are put there."""
        if not numbers:
            return "0"
        first, listed = _PLACED.fullmatch(numbers[0]), ", ".join(numbers)
        if first and numbers == [f"{first[1]}[{int(first[2]) + i}]" for i in range(len(numbers))]:
            return f"&{numbers[0]}"
        if listed not in self._gathered:
            name = self._gathered[listed] = f"g{len(self._gathered)}"
            self._add(f"const {self.type} {name}[{len(numbers)}]={{{listed}}};")
        return self._gathered[listed]

    def _called(self, function: Any, numbers: list[str]) -> list[str]:
        """Results of a function."""
        sizes = [function.nnz_in(k) for k in range(function.n_in())]
        parts = [numbers[end - size : end] for size, end in zip(sizes, accumulate(sizes), strict=True)]
        how = written(function)
        asked = how.otherwise is not None
        given = [self._beside(part) for part in parts[asked:]]
        found = {f"t{next(self._vectors)}": function.nnz_out(k) for k in range(function.n_out())}
        for t, size in found.items():
            self._add(f"{self.type} {t}[{size or 1}];")
        handed, otherwise = ", ".join([*given, *found]), ""
        call = f"{self.writer.named(how.function if asked else function)}({handed});"
        if how.otherwise is IDLE:
            for t, place in zip(found, given, strict=False):
                self._add(f"const {self.type} *p{t}={place};")
                call += f" p{t}={t};"
            found = {f"p{t}": size for t, size in found.items()}
        elif asked:
            otherwise = f" else {{ {self.writer.named(how.otherwise)}({handed}); }}"
        if asked:
            call = f"if ({self.forms['asked'].format(parts[0][0])}) {{ {call} }}{otherwise}"
        self._add(call)
        return [f"{name}[{i}]" for name, size in found.items() for i in range(size)]


def _index(place: int, paired: bool) -> str:
    """Index of a number in a vector; of one of two that lie side by side, in the loop over both."""
    return f"{2 * place}+i" if paired else str(place)
