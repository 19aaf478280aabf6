"""CasADi's functions as C, written from their instructions: for numbers, or for vectors of several runs.

What is only moved is read where it lies, a result is made where it belongs, and an idle function leaves its
arguments as they are by pointing at them. A choice is one expression, which becomes one or two instructions;
what is given and what is found are said not to overlap; and single numbers are handed over as numbers.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from warmlink.fmus.calls import in_a_loop
from warmlink.fmus.packaging.native.c_forms import Dialect, Number, Numbers, dialect, moves, stride

DECLARED = ("settle", "margins", "begin", "begin_tangent", "advance", "rates", "rates_tangent", "tangent")
"""Functions that `model.h` declares; others are for the generated file alone."""

_LANES = Path(__file__).parent / "sources" / "lanes.h"
"""Vectors and their functions, of so many `LANES`."""

_FOR = "for (int {0}=0; {0}<{1}; ++{0}) "


def functions_text(functions: Iterable[Any], declared: Collection[str] = DECLARED, lanes: int = 0) -> str:
    """C functions from CasADi's, each as `void NAME(const double *x0, ..., double *y0)`.

    Parameters
    ----------
    functions : of numbers (SX), or of vectors and calls (MX)
    declared : names of those that a header declares under `WL(NAME)`; the others are static, as `NAME_of`
    lanes : where given, so many runs go side by side: in place of each double is a vector of gcc and clang,
        `lanes`, of which every element is computed as the number would be, in the same order
    """
    writer = _Writer(dialect(lanes > 0))
    for each in functions:
        name = each.name()
        writer.write(f"void WL({name})" if name in declared else f"static void {name}_of", each, alone=False)
    header = f"#define LANES {lanes}\n{_LANES.read_text('utf-8')}" if lanes else "#include <math.h>\n"
    return "\n".join([header, *writer.texts])


class _Writer:
    """C of functions, each of them once and after those that it calls."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self.texts: list[str] = []
        self._names: dict[int, str] = {}

    def write(self, head: str, function: Any, alone: bool) -> None:
        """Write a function that takes single numbers `alone`, as they are, or by pointers as all else."""
        alones = [alone and function.nnz_in(k) == 1 for k in range(function.n_in())]
        one, paired = in_a_loop(function) or (function, [False] * len(alones))
        body = _Body(self, one if self._writable(one) else one.expand(), alones, paired)
        lines, used = body.lines()
        if any(paired):
            lines = [_FOR.format("i", 2) + "{", *(f"  {line}" for line in lines), "}"]
        lines = [f"(void)x{k};" for k in range(len(alones)) if f"x{k}" not in used] + lines
        real = self.dialect.real
        parameters = [f"{real} x{k}" if a else f"const {real} *restrict x{k}" for k, a in enumerate(alones)]
        parameters += [f"{real} *restrict y{k}" for k in range(function.n_out())]
        text = "".join(f"  {line}\n" for line in lines)
        self.texts.append(f"{head}({', '.join(parameters)})\n{{\n{text}}}\n")

    def named(self, function: Any) -> str:
        """Name in C of a function that is called."""
        key = function.__hash__()
        if key not in self._names:
            self._names[key] = name = f"{function.name()}_{len(self._names)}"
            self.write(f"static void {name}", function, alone=True)
        return self._names[key]

    def _writable(self, function: Any) -> bool:
        """Whether a function of vectors is made of what is written here; else each number is told apart."""
        import casadi

        others = "INPUT", "OUTPUT", "CONST", "CALL", "DOT", "MTIMES"
        known = {*self.dialect.operations, *moves(), *(getattr(casadi, f"OP_{name}") for name in others)}
        kinds = {function.instruction_id(k) for k in range(function.n_instructions())}
        return not function.is_a("MXFunction") or kinds <= known


class _Body:
    """Statements of a function.

    Parameters
    ----------
    writer : writes the functions that this one calls
    function : of numbers (SX) or of vectors and calls (MX)
    alone : for each argument whether it is a single number
    paired : for each argument whether it holds two side by side; if any does, the statements are those of a
        loop over both, and so are the results
    """

    def __init__(self, writer: _Writer, function: Any, alone: Sequence[bool], paired: Sequence[bool]) -> None:
        import casadi

        self.writer, self.dialect, self._function = writer, writer.dialect, function
        self._alone, self._paired = alone, paired
        self._statements: list[tuple[str, Sequence[str], Numbers]] = []
        """C, the names that it makes (none: results of the function), and what it uses."""
        self._sizes: dict[str, int] = {}  # of vectors that are declared, by name
        self._placed: dict[str, str] = {}  # where in a result vectors lie that are a part of it
        self._made: dict[tuple[Number, ...], tuple[int, list[Numbers]]] = {}  # by which operation, of what
        self._gathered: dict[tuple[Number, ...], Number] = {}
        held: dict[int, Numbers] = {}  # in CasADi's places
        for k in range(function.n_instructions()):
            kind, given, taken = (
                getattr(function, f"instruction_{what}")(k) for what in ("id", "input", "output")
            )
            node = function.instruction_MX(k) if function.is_a("MXFunction") else None
            if kind == casadi.OP_INPUT:
                first, size = (given[1], 1) if node is None else (node.info()["offset"], node.nnz())
                held[taken[0]] = [self._argument(given[0], first + i) for i in range(size)]
            elif kind == casadi.OP_OUTPUT:
                self._put(held[given[0]], taken[0], taken[1] if node is None else node.info()["offset"])
            elif kind == casadi.OP_CONST:
                values = [function.instruction_constant(k)] if node is None else node.to_DM().nonzeros()
                held[taken[0]] = [self.dialect.literal(each) for each in values]
            else:
                found = self._found(kind, node, [held.get(place, []) for place in given])
                held |= zip(taken, found, strict=True)

    def lines(self) -> tuple[list[str], set[str]]:
        """Lines of what any result needs, and the names that they use."""
        needed: set[str] = set()
        lines: list[str] = []
        for text, makes, uses in reversed(self._statements):
            if not makes or not needed.isdisjoint(makes):
                needed.update(each.name for each in uses)
                lines += [text, *(self._declared(name) for name in makes if name in self._sizes)]
        return [line for line in reversed(lines) if line], needed

    def _declared(self, name: str) -> str:
        if name in self._placed:
            return f"{self.dialect.real} *{name}={self._placed[name]};"
        return f"{self.dialect.real} {name}[{self._sizes[name]}];"

    def _add(self, text: str, makes: Sequence[str], *uses: Numbers) -> None:
        self._statements.append((text, makes, [each for part in uses for each in part]))

    def _argument(self, which: int, index: int) -> Number:
        if self._alone[which]:
            return Number(f"x{which}")
        return Number(f"x{which}[{2 * index}+i]") if self._paired[which] else Number(f"x{which}", index)

    def _put(self, numbers: Numbers, which: int, first: int) -> None:
        """Hand over numbers as a result from an index on; a vector that is a part of it is made there."""
        keys = [(each.name, (each.place or 0) - i) for i, each in enumerate(numbers)]
        for _, places in groupby(range(len(numbers)), keys.__getitem__):
            run = [numbers[i] for i in places]
            text, name = "", run[0].name
            if self._sizes.get(name) == len(run) and name not in self._placed:
                self._placed[name] = Number(f"y{which}", first).pointer
            elif len(run) > 1:
                text = f"{_FOR.format('i', len(run))}y{which}[{first}+i]={self._in_loop(run)[0]};"
            else:
                text = f"y{which}[{f'{2 * first}+i' if any(self._paired) else first}]={run[0]};"
            self._add(text, (), run)
            first += len(run)

    def _found(self, kind: int, node: Any, given: list[Numbers]) -> list[Numbers]:
        """What an instruction finds, which does more than to hand over."""
        import casadi

        if kind in self.dialect.operations:
            return [self._each(kind, given)]
        if node is None:
            raise ValueError(f"{self._function.name()}: CasADi's operation {kind} has no form in C")
        if kind == casadi.OP_CALL:
            return self._called(node.which_function(), given)
        if kind == casadi.OP_DOT:
            return [self._product(1, len(given[0]), 1, [self.dialect.literal(0)], *given)]
        sparse = [(numbers, node.dep(i).sparsity()) for i, numbers in enumerate(given)]
        if kind == casadi.OP_MTIMES:
            dense = [self._moved(casadi.densify, each) for each in sparse]
            product = self._product(*sparse[1][1].shape, sparse[2][1].size2(), *dense)
            return [[product[i] for i in node.sparsity().find()]]
        return [self._moved(partial(moves()[kind], node), *sparse)]

    def _each(self, kind: int, given: list[Numbers]) -> Numbers:
        """What an operation makes of each number, or of each and a single one."""
        kind, form, given = self._chosen(kind, given)
        size, real = max(map(len, given)), self.dialect.real
        if size == 1:
            found = [Number(f"a{len(self._statements)}")]
            text = form.format(*(numbers[0] for numbers in given))
            self._add(f"const {real} {found[0]}={text};", [found[0].name], *given)
        else:
            read = [self._in_loop(numbers) for numbers in given]
            found = self._vector(size)
            text = f"{found[0].name}[i]={form.format(*(text for text, _ in read))};"
            self._add(_FOR.format("i", size) + text, [found[0].name], [first for _, first in read])
        self._made[tuple(found)] = kind, given
        return found

    def _chosen(self, kind: int, given: list[Numbers]) -> tuple[int, str, list[Numbers]]:
        """An operation and its form; what adds that under a condition to that otherwise is one choice."""
        import casadi

        parts = [self._made.get(tuple(each), (0, [])) for each in given]
        if kind == casadi.OP_ADD and all(made == casadi.OP_IF_ELSE_ZERO for made, _ in parts):
            (one, then), (other, otherwise) = (each for _, each in parts)
            if self._made.get(tuple(other)) == (casadi.OP_NOT, [one]):
                return kind, self.dialect.choice, [one, then, otherwise]
            if self._made.get(tuple(one)) == (casadi.OP_NOT, [other]):
                return kind, self.dialect.choice, [other, otherwise, then]
        return kind, self.dialect.operations[kind], given

    def _vector(self, size: int) -> Numbers:
        """A new vector."""
        name = f"t{len(self._sizes)}"
        self._sizes[name] = max(size, 1)
        return [Number(name, i) for i in range(size)]

    def _in_loop(self, numbers: Numbers) -> tuple[str, Number]:
        """How a loop over `i` reads numbers, and the first of them."""
        first, step = numbers[0], stride(numbers)
        if all(each == first for each in numbers):
            return str(first), first
        if step is None:
            first, step = self._beside(numbers), 1
        return f"{first.name}[{first.place}+{'' if step == 1 else f'{step}*'}i]", first

    def _beside(self, numbers: Numbers) -> Number:
        """The first of numbers that lie side by side, or are put there."""
        if not numbers:
            return Number("0")
        if stride(numbers) == 1:
            return numbers[0]
        key = tuple(numbers)
        if key not in self._gathered:
            first = self._gathered[key] = Number(f"g{len(self._gathered)}", 0)
            listed = ", ".join(map(str, numbers))
            text = f"const {self.dialect.real} {first.name}[{len(numbers)}]={{{listed}}};"
            self._add(text, [first.name], numbers)
        return self._gathered[key]

    def _product(self, rows: int, inner: int, columns: int, *given: Numbers) -> Numbers:
        """Dense matrix, to which the product of the next two is added."""
        found = self._vector(rows * columns)
        starts = [self._beside(each) for each in given]
        z, x, y = (f"({each.pointer})" for each in starts)
        place = f"[i+{rows}*j]"
        over_columns, over_inner, over_rows = map(_FOR.format, "jki", (columns, inner, rows))
        start = f"{over_columns}{over_rows}{found[0].name}{place}={z}{place};"
        term = f"{found[0].name}{place}+={x}[i+{rows}*k]*{y}[k+{inner}*j];"
        self._add(f"{start}\n  {over_columns}{over_inner}{over_rows}{term}", [found[0].name], starts)
        return found

    def _moved(self, move: Callable[..., Any], *given: tuple[Numbers, Any]) -> Numbers:
        """Numbers of matrices, with their structures, as CasADi moves them; what it fills up is 0."""
        import casadi

        pool, matrices = [self.dialect.literal(0)], []
        for numbers, sparsity in given:
            matrices.append(casadi.DM(sparsity, range(len(pool), len(pool) + len(numbers))))
            pool += numbers
        return [pool[int(i)] for i in move(*matrices).nonzeros()]

    def _called(self, function: Any, given: list[Numbers]) -> list[Numbers]:
        """Results of a function; of one that is idle where its first argument is 0, its next ones there."""
        inside = {each.name(): each for each in function.find_functions(0)}
        run = inside.get(f"{function.name()}_run")
        found = [self._vector(function.nnz_out(k)) for k in range(function.n_out())]
        names = [*self._sizes][-len(found) :]
        text, used = self._call(run or function, given[run is not None :], names)
        if run is None:
            self._add(text, names, used)
            return found
        before = after = ""
        for k, (name, numbers) in enumerate(zip([*names], given[1:], strict=False)):
            first = self._beside(numbers)
            before += f"const {self.dialect.real} *p{name}={first.pointer};\n  "
            after += f" p{name}={name};"
            found[k] = [Number(f"p{name}", i) for i in range(len(numbers))]
            names.append(f"p{name}")
            used.append(first)
        asked = self.dialect.asked.format(given[0][0])
        self._add(f"{before}if ({asked}) {{ {text}{after} }}", names, [given[0][0], *used])
        return found

    def _call(self, function: Any, given: list[Numbers], names: Sequence[str]) -> tuple[str, Numbers]:
        """A call that gives vectors their numbers, and what it uses."""
        handed, used = [], []
        for k, numbers in enumerate(given):
            alone = function.nnz_in(k) == 1
            used.append(numbers[0] if alone else self._beside(numbers))
            handed.append(str(used[-1]) if alone else used[-1].pointer)
        return f"{self.writer.named(function)}({', '.join([*handed, *names])});", used
