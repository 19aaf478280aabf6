"""CasADi's functions as C, written from their instructions: for numbers, or for vectors of several runs.

What is only moved is read where it lies, a result is made where it belongs, and an idle function leaves its
arguments as they are by pointing at them. A choice is one expression, which becomes one or two instructions;
what is given and what is found are said not to overlap; and single numbers are handed over as numbers.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import accumulate, groupby
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
        writer.write(f"void WL({name})" if name in declared else f"static void {name}_of", each, alone=False)
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

    def write(self, head: str, function: Any, alone: bool) -> None:
        """Write a function that takes single numbers `alone`, as they are, or by pointers as all else."""
        alones = [alone and function.nnz_in(k) == 1 for k in range(function.n_in())]
        whole, paired, *_ = written(function)
        with unsimplified():
            numbers = whole.expand() if whole.is_a("MXFunction") else whole
        lines = _Body(self, numbers, alones, paired).lines()
        if paired:
            lines = ["for (int i=0; i<2; ++i) {", *(f"  {line}" for line in lines), "}"]
        one, many = f"{self.type} ", f"{self.type} *restrict "
        declared = {f"x{k}": one if single else f"const {many}" for k, single in enumerate(alones)}
        declared |= {f"y{k}": many for k in range(function.n_out())}
        used = set(re.findall(r"\w+", " ".join(lines)))
        lines = [f"(void){name};" for name in declared if name not in used] + lines
        parameters = (kind + name for name, kind in declared.items())
        text = "".join(f"  {line}\n" for line in lines)
        self.texts.append(f"{head}({', '.join(parameters)})\n{{\n{text}}}\n")

    def named(self, function: Any) -> str:
        """Name in C of a function that is called."""
        key, by_hand = function.__hash__(), written(function).by_hand
        if by_hand:
            return by_hand
        if key not in self._names:
            self._names[key] = name = f"{function.name()}_{len(self._names)}"
            self.write(f"static void {name}", function, alone=True)
        return self._names[key]


class _Body:
    """Statements of a function.

    Parameters
    ----------
    writer : writes the functions that this one calls
    function : of numbers, and of calls of such
    alone : for each argument whether it is a single number
    paired : how many of the first arguments hold two of each number side by side; if any do, the statements
        are those of a loop over both, and so are the results
    """

    def __init__(self, writer: _Writer, function: Any, alone: Sequence[bool], paired: int) -> None:
        self.writer, self.forms, self.type, self.name = writer, writer.forms, writer.type, function.name()
        self._statements: list[tuple[str, Sequence[str]]] = []
        """C, and the names that it makes; none: results of the function."""
        self._vectors: dict[str, tuple[int, str]] = {}
        """By name: numbers that a call finds, 0 where they lie in a result; declaration."""
        self._made: dict[str, tuple[str, list[str]]] = {}  # by which operation, of what
        self._gathered: dict[str, str] = {}
        handed: list[tuple[int, int, str, int]] = []  # what of results lies in vectors: of which, where
        held: dict[int, str] = {}  # in CasADi's places
        nodes = function.instructions_sx()
        for k in range(function.n_instructions()):
            kind = writer.operations[function.instruction_id(k)]
            given, taken = function.instruction_input(k), function.instruction_output(k)
            if kind == "INPUT":
                which, place = given
                index = f"{2 * place}+i" if which < paired else place
                held[taken[0]] = f"x{which}" if alone[which] else f"x{which}[{index}]"
            elif kind == "CONST":
                held[taken[0]] = self._literal(function.instruction_constant(k))
            elif kind == "CALL":
                found = self._called(nodes.nz[k].which_function(), [held[place] for place in given])
                held |= zip(taken, found, strict=True)
            elif kind != "OUTPUT":
                held[taken[0]] = self._operation(kind, [held[place] for place in given])
            elif paired:
                self._add(f"y{taken[0]}[{2 * taken[1]}+i]={held[given[0]]};")
            elif placed := _PLACED.fullmatch(held[given[0]]):
                handed.append((*taken, placed[1], int(placed[2])))
            else:
                self._add(f"y{taken[0]}[{taken[1]}]={held[given[0]]};")
        self._hand_over(sorted(handed))

    def lines(self) -> list[str]:
        """Lines of what any result needs."""
        needed, lines = {name for name, (size, _) in self._vectors.items() if not size}, list[str]()
        for text, makes in reversed(self._statements):
            if not makes or not needed.isdisjoint(makes):
                for name in (made for made in makes if made[0] == "p" and made not in needed):
                    # Of a call's results that may be its arguments nobody asks for this one.
                    text = re.sub(rf"const [^\n]* \*{name}=[^\n]*;\n  | {name}={name[1:]};", "", text)
                needed.update(re.findall(r"\w+", text))
                lines += [text, *(self._vectors[name][1] for name in makes if name in self._vectors)]
        return lines[::-1]

    def _add(self, text: str, *makes: str) -> None:
        self._statements.append((text, makes))

    def _hand_over(self, handed: list[tuple[int, int, str, int]]) -> None:
        """Copy what lies in vectors to the results, but for a vector that is a part of one: it lies there."""
        keys = [(of, place - i, name, at - i) for i, (of, place, name, at) in enumerate(handed)]
        for _, places in groupby(range(len(handed)), keys.__getitem__):
            run = [handed[i] for i in places]
            which, first, name, at = run[0]
            if self._vectors.get(name, (0, ""))[0] == len(run):
                self._vectors[name] = 0, f"{self.type} *{name}=&y{which}[{first}];"
            else:
                self._add(f"for (int i=0; i<{len(run)}; ++i) y{which}[{first}+i]={name}[{at}+i];")

    def _literal(self, value: float) -> str:
        """A number that is written out, with a point."""
        text = f"{value:#}".replace("inf", "(double)INFINITY").replace("nan", "(double)NAN")
        return self.forms["constant"].format(f"({text})" if text[0] == "-" else text)

    def _operation(self, kind: str, given: list[str]) -> str:
        """Result of an operation; what adds that under a condition to that otherwise is one choice."""
        form = self.forms.get(kind)
        if form is None:
            told = f"{self.name}: CasADi's operation {kind.lower()} has no C here"
            raise InputError(f"{told}; write it with others")
        parts = [self._made.get(each, ("", [])) for each in given] if kind == "ADD" else []
        if parts and all(made == "IF_ELSE_ZERO" for made, _ in parts):
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
            self._add(f"const {self.type} {name}[{len(numbers)}]={{{listed}}};", name)
        return self._gathered[listed]

    def _called(self, function: Any, numbers: list[str]) -> list[str]:
        """Results of a function."""
        sizes = [function.nnz_in(k) for k in range(function.n_in())]
        parts = [numbers[end - size : end] for size, end in zip(sizes, accumulate(sizes), strict=True)]
        given = [part[0] if len(part) == 1 else self._beside(part) for part in parts]
        how, named = written(function), self.writer.named
        found = {f"t{len(self._vectors) + k}": function.nnz_out(k) for k in range(function.n_out())}
        self._vectors |= {t: (size, f"{self.type} {t}[{size or 1}];") for t, size in found.items()}
        asked, made, lines = how.otherwise is not None, [*found], list[str]()
        handed = ", ".join([*given[asked:], *found])
        call = f"{named(how.function if asked else function)}({handed});"
        if how.otherwise is IDLE:
            left = map(self._beside, parts[1 : len(found) + 1])
            lines = [f"const {self.type} *p{t}={place};" for t, place in zip(found, left, strict=True)]
            call += "".join(f" p{t}={t};" for t in found)
            found = {f"p{t}": size for t, size in found.items()}
            made += found
        if asked:
            other = "" if how.otherwise is IDLE else f" else {{ {named(how.otherwise)}({handed}); }}"
            call = f"if ({self.forms['asked'].format(given[0])}) {{ {call} }}{other}"
        self._add("\n  ".join([*lines, call]), *made)
        return [f"{name}[{i}]" for name, size in found.items() for i in range(size)]
