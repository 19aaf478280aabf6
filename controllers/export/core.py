"""A law as plain C: the functions of its FMU behind a struct, `init` and `step`, and what goes with them.

An export's folder holds the core, a program that tests it, and a README.
"""

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.calls import IDLE, written
from warmlink.fmus.component import Component
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.packaging.native.c_code import functions_text
from warmlink.fmus.packaging.native.casadi_code import Symbols, beginning, function, sampling

Precision = Literal["double", "single"]

_NUMBER = re.compile(r"(?<![\w.])\d+\.\d*(?:e[+-]?\d+)?(?![\w.])")
"""A number with a point in C."""

_LARGEST_SINGLE = 3e38

_MATH = re.compile(r"\b(exp|log|sqrt|sin|cos|erf|fabs|floor)\(")
"""A call of the C library."""


@dataclass(frozen=True)
class Core:
    """A law that is written as C.

    Attributes
    ----------
    component : the law, its parameters' start values being the design
    name : what files and functions are named after
    precision : of its arithmetic
    """

    component: Component
    name: str
    precision: Precision

    @property
    def design(self) -> Number:
        """Parameters and what they settle, shape (d.size,)."""
        return self.component.settled(self.component.start_values()[0])

    def header(self) -> str:
        """The text of `NAME.h`."""
        given, upper = self.component, self.name.upper()
        return self.filled(
            "core.h",
            real="double" if self.precision == "double" else "float",
            inputs=_listed(upper, given.u.names),
            outputs=_listed(upper, given.y.names),
        )

    def source(self) -> str:
        """The text of `NAME.c`."""
        text = functions_text(self._functions(), declared=())
        table = ",\n".join(f"    {float(value)!r}" for value in self.design)
        text += "\n/* The design: parameters, and what follows from them. */\n"
        text += f"static const double design[] = {{\n{table}\n}};\n"
        text = re.sub(r"\bdouble\b", f"{self.name}_real", text + self._calls())
        if self.precision == "single":
            text = _MATH.sub(r"\1f(", _NUMBER.sub(_single, text))
        return f'#include "{self.name}.h"\n\n{text}'

    @property
    def period(self) -> float:
        """Sample time in s."""
        return float(self.design[self.component.d.index["sample_time"]])

    def operations(self) -> int:
        """Arithmetic operations of a sample and its outputs."""
        sample, outputs = list(self._functions())[1:]
        return sum(_operations(each) for each in (sample, outputs))

    def _functions(self) -> Iterator[Any]:
        yield function(*next(beginning(self.component)))
        yield function(*sampling(self.component, 0))
        s = Symbols.of(self.component, calls=self.component.sampled)
        now = [s.x, s.u, s.d, s.time]
        yield function("outputs", now, self.component.outputs_of(*now))

    @property
    def goes_on(self) -> bool:
        """Whether the law can go on from what it retained of a run before."""
        return "recalled_for" in self.component.p.index

    def _calls(self) -> str:
        size = self.component.d.size
        own = "    const double *own = design;\n"
        if self.goes_on:
            recalled = [i for name, i in self.component.d.index.items() if name.startswith("recalled[")]
            own = f"""    double own[{size}];
    int i;
    for (i = 0; i < {size}; i++)
        own[i] = design[i];
    for (i = 0; retained && i < {len(recalled)}; i++)
        own[{recalled[0]} + i] = retained[i];
    own[{self.component.d.index["recalled_for"]}] = retained ? passed : -1;
"""
        return self.filled("core.c", own=own, step=repr(self.period))

    def filled(self, template: str, **more: object) -> str:
        """Text of a file in `templates` with values in place of their names, as `${law}`."""
        path = Path(__file__).parent / "templates" / template
        retained = f",\n    const {self.name}_real retained[], {self.name}_real passed"
        return Template(path.read_text("utf-8")).substitute(
            law=self.name,
            upper=self.name.upper(),
            description=self.component.description,
            period=f"{self.period:g}",
            states=self.component.x.size,
            recalls=retained if self.goes_on else "",
            **more,
        )


def designed(component: Component, values: dict[str, float]) -> Component:
    """The law with the values of a parameter set by scalar name; raises KeyError where it has none such."""
    from dataclasses import replace

    return replace(component, parameters=with_scalars(component.parameters, values))


def _listed(prefix: str, names: Iterable[str]) -> str:
    plain = (re.sub(r"\W+", "_", name).strip("_").upper() for name in names)
    return "".join(f"    {prefix}_{name},\n" for name in plain)


def _single(number: re.Match[str]) -> str:
    return f"{_LARGEST_SINGLE if float(number[0]) > _LARGEST_SINGLE else number[0]}f"


def _operations(function: Any) -> int:
    """Operations of a CasADi function and of those it calls; those on vectors count once for each element."""
    import casadi

    if written(function).otherwise is IDLE:  # while it is not
        function = written(function).function
    if not function.is_a("MXFunction"):
        moved = (casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST)
        kinds = (function.instruction_id(k) for k in range(function.n_instructions()))
        return sum(1 for kind in kinds if kind not in moved)
    count = 0
    for k in range(function.n_instructions()):
        node = function.instruction_MX(k)
        if function.instruction_id(k) == casadi.OP_CALL:
            count += _operations(node.which_function())
        elif node.n_dep() and function.instruction_id(k) != casadi.OP_OUTPUT:
            count += int(node.nnz())
    return count


SAMPLES = 120
"""Samples of the test vectors."""

TOLERANCES = {"double": 1e-9, "single": 0.05e-6}
"""Largest difference from the test vectors: a share of each output, or m of the correction."""


def export_files(core: Core) -> dict[str, str]:
    """Text of each file of an export by name."""
    return {
        f"{core.name}.h": core.header(),
        f"{core.name}.c": core.source(),
        f"{core.name}_test.c": test_program(core),
        "README.md": readme(core),
    }


def vectors(core: Core) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Inputs and outputs of the law from a cold start, by its Python form.

    Returns
    -------
    inputs, outputs : shapes (SAMPLES + 1, u.size) and (SAMPLES + 1, y.size); the first row is the start
    """
    instance = Instance(core.component)
    given, taken = list(_inputs(core)), []
    for sample, row in enumerate(given):
        instance.set(dict(zip(core.component.u.names, row, strict=True)))
        if sample == 0:
            instance.initialize()
        else:
            instance.step((sample - 1) * core.period, core.period)
        taken.append(np.array(instance.outputs()))
    return np.array(given), np.array(taken)


def test_program(core: Core) -> str:
    """A C program that runs the core through the test vectors; it ends with 0 where they are met."""
    upper = core.name.upper()
    given, taken = vectors(core)
    compared, scale = f"{upper}_CORRECTION + 1", "1"
    if core.precision == "double":
        compared, scale = f"{upper}_OUTPUTS", "fmax(1e-6, fabs(outputs[k][i]))"
    return core.filled(
        "test.c",
        given=_table(given),
        taken=_table(taken),
        count=len(given),
        nothing=", 0, 0" if core.goes_on else "",
        compared=compared,
        scale=scale,
        tolerance=repr(TOLERANCES[core.precision]),
    )


_RESTART = """
After a restart, `retained` are the outputs of that name that were stored before, and `passed` is the time
in s since then; where nothing was stored, give a null pointer and 0.
"""


def readme(core: Core) -> str:
    """How to use the export, and what it needs."""
    size = 4 if core.precision == "single" else 8
    return core.filled(
        "readme.txt",
        precision=core.precision,
        memory=8 * math.ceil((core.component.x.size + core.component.y.size) * size / 8) + 8,
        operations=core.operations(),
        samples=SAMPLES,
        kept=", retained, passed" if core.goes_on else "",
        more=_RESTART if core.goes_on else "",
    )


def _inputs(core: Core) -> Iterator[list[float]]:
    """A motor that starts and stops in a room that warms up, one reading missing for a while."""
    component = core.component
    _, start = component.start_values()
    for sample in range(SAMPLES + 1):
        row = dict(zip(component.u.names, start.tolist(), strict=True))
        warm = 6.0 * (1.0 - math.exp(-sample / 60.0))
        for place, name in enumerate(name for name in row if name.endswith("_temperature")):
            row[name] = 295.15 + warm / (1 + place) + 0.05 * math.sin(1.7 * sample + place)
        row["ambient_temperature"] = 295.15 + sample * core.period / 3600.0
        row["speed"], row["torque"] = (3.0, 2.5) if sample % 60 < 40 else (0.0, 0.0)
        if 50 <= sample < 70:
            row["tip_temperature"] = math.nan
        yield list(row.values())


def _table(rows: NDArray[np.float64]) -> str:
    text = "".join("    {" + ", ".join(repr(float(each)) for each in row) + "},\n" for row in rows)
    return re.sub(r"\bnan\b", "NAN", text)
