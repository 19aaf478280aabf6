"""An exported law as libraries, from its C and from its Structured Text, and inputs that try both."""

import ctypes
import os
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import warmlink as wl
from tests.built import built
from warmlink.controllers.export.c_files import export_files
from warmlink.controllers.export.core import Core
from warmlink.controllers.export.st_blocks import structured_text
from warmlink.controllers.interface import SENSED

Array = NDArray[np.float64]

FOLDER = os.environ.get("WARMLINK_MATIEC", "")
MATIEC = Path(FOLDER)
"""The folder in which matiec (github.com/beremiz/matiec) was built: autoreconf -i && ./configure && make."""

MISSING = (
    None
    if FOLDER and (MATIEC / "iec2c").is_file()
    else "matiec is not there: give its folder as WARMLINK_MATIEC"
)

_PROGRAM = """
PROGRAM main
VAR law : {law}; END_VAR
law();
END_PROGRAM
"""

_PROJECT = """
CONFIGURATION config
  RESOURCE res ON PLC
    TASK each_sample(INTERVAL := T#1s, PRIORITY := 0);
    PROGRAM p WITH each_sample : {program};
  END_RESOURCE
END_CONFIGURATION
"""

_FLAGS = ("-std=gnu99", "-O1", "-ffp-contract=off", "-fPIC", "-shared")


def translated(core: Core, folder: Path, program: str = _PROGRAM) -> str:
    """Translate the law's Structured Text to C with matiec, in a folder; what it complains of.

    The law is called by a program, whose name stands after the word.
    """
    called = program.split()[1]
    text = structured_text(core) + program.format(law=core.name) + _PROJECT.format(program=called)
    (folder / "law.st").write_text(text, encoding="utf-8")
    command = [MATIEC / "iec2c", "-I", MATIEC / "lib", "-T", ".", "law.st"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    said = "\n".join(line for line in done.stdout.splitlines() if not line.endswith((".c", ".h", ".csv")))
    return done.stderr.strip() + said.strip() + ("" if done.returncode == 0 else " failed")


def of_structured_text(core: Core, folder: Path) -> Path:
    """The library of a law's Structured Text."""
    told = translated(core, folder)
    assert not told, told
    block, component = core.name.upper(), core.component
    given = "".join(f"fb.{name.upper()}.value = u[{i}];" for i, name in enumerate(component.u.names))
    taken, place = "", 0
    for slot in core.program.outputs:
        at = f"fb.{slot.name.upper()}.value"
        for i in range(slot.size):
            taken += f"y[{place + i}] = {at}{f'.table[{i}]' if slot.shape else ''};"
        place += slot.size
    # matiec's own start clears arrays that are retained, which a controller keeps
    keep = "__typeof__(fb.RETAINED) kept = fb.RETAINED;" if core.goes_on else ""
    again = "if (restart) { fb.RETAINED = kept; fb.PASSED.value = passed; }" if core.goes_on else ""
    (folder / "st_run.c").write_text(
        f"""#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"
#include "POUS.c"
TIME __CURRENT_TIME;
BOOL __DEBUG;
static {block} fb;
void begin(int restart, double passed) {{ {keep} {block}_init__(&fb, 0); {again} }}
void step(const double *u, double *y) {{ {given} {block}_body__(&fb); {taken} }}
""",
        encoding="utf-8",
    )
    command = ["cc", *_FLAGS, "-w", f"-I{MATIEC / 'lib' / 'C'}", "st_run.c", "-lm", "-o", "st.so"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "st.so"


@cache
def files_of(core: Core) -> dict[str, str]:
    """What an export writes, once for the tests that read or run it."""
    return export_files(core)


def written(core: Core, folder: Path) -> Path:
    """The folder with what an export writes."""
    for name, text in files_of(core).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def of_c(core: Core, folder: Path) -> Path:
    """The library of a law's C."""
    law, component = core.name, core.component
    written(core, folder)
    begin = f"{law}_init(&law, &in);"
    if core.goes_on:
        size = sum(slot.size for slot in core.program.outputs if slot.name == "retained")
        begin = f"""{law}_real kept[{size}];
        memcpy(kept, law.outputs.retained, sizeof kept);
        {law}_init(&law, &in, again ? kept : NULL, ({law}_real)passed);"""
    (folder / "c_run.c").write_text(
        f"""#include <string.h>
#include <stddef.h>
#include "{law}.h"
static {law} law;
static int fresh, again;
static double passed;
void begin(int restart, double for_long) {{ fresh = 1; again = restart; passed = for_long; (void)again; }}
void step(const double *u, double *y)
{{
    {law}_real v[{component.u.size}], o[{component.y.size}];
    {law}_inputs in;
    int i;
    for (i = 0; i < {component.u.size}; i++)
        v[i] = ({law}_real)u[i];
    memcpy(&in, v, sizeof in);
    if (fresh) {{
        {begin}
        fresh = 0;
    }} else
        {law}_step(&law, &in);
    memcpy(o, &law.outputs, sizeof o);
    for (i = 0; i < {component.y.size}; i++)
        y[i] = o[i];
}}
""",
        encoding="utf-8",
    )
    texts = [(path.name, path.read_bytes()) for path in sorted(folder.glob("*.[ch]"))]
    return built(["cc", *_FLAGS, "-Wall", "-Werror", "c_run.c", f"{law}.c", "-lm"], texts, folder / "c.so")


def run(library: Path, inputs: Array, outputs: int, restarts: Mapping[int, float]) -> Array:
    """What a law says to rows of inputs; before some rows the controller was off for so many s."""
    law, rows = ctypes.CDLL(str(library)), np.ascontiguousarray(inputs)
    said = np.zeros((len(rows), outputs))
    law.begin(0, ctypes.c_double(-1.0))
    for k in range(len(rows)):
        if k in restarts:
            law.begin(1, ctypes.c_double(restarts[k]))
        law.step(rows[k].ctypes.data_as(ctypes.c_void_p), said[k].ctypes.data_as(ctypes.c_void_p))
    return said


@cache
def hours(core_inputs: tuple[str, ...], count: int, seed: int = 1) -> Array:
    """Rows of inputs, 1 s apart: shifts of the cell with noisy thermometers, and faults of every kind.

    Drop-outs of up to two minutes, shifts of 5 K, readings that are stuck, and duty signals that are none.
    """
    rng = np.random.default_rng(seed)
    place = {name: i for i, name in enumerate(core_inputs)}
    cell = wl.run("shift_with_breaks", "none", mismatches=["noisy_sensors"], stop=f"{count} s")
    rows = np.zeros((count, len(place)))
    for name, source in cell.scenario.machine.fed.items():
        part, _, given = name.rpartition(".")
        if part == "compensator" and given in place:
            rows[:, place[given]] = cell.table[source][:count]
    for name in SENSED:
        column = rows[:, place[name]]
        for start in np.flatnonzero(rng.random(count) < 0.0005):
            column[start : start + int(rng.integers(1, 120))] = np.nan
        for start in rng.integers(0, count, 1 + count // 20000):
            column[start : start + 200] += 5.0
        for start in rng.integers(0, count, 1 + count // 30000):
            column[start : start + 300] = column[start]
    rows[rng.random(count) < 0.001, place["speed"]] = np.nan
    rows[rng.random(count) < 0.001, place["torque"]] = 1e20
    seen = 2e-7 * rng.standard_normal(count // 60 + 1)
    rows[:, place["measured_drift"]] = np.repeat(seen, 60)[:count]
    rows[:, place["drift_valid"]] = np.arange(count) % 7200 > 600
    return rows
