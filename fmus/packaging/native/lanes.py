"""CasADi's C with vectors in place of numbers: several runs side by side in the lanes of a processor.

The vectors are those of gcc and clang. Every lane computes what the plain text computes, in the same order.
"""

import re
from functools import cache
from pathlib import Path

_HEADER = Path(__file__).parent / "sources" / "lanes.h"
"""Vectors and their functions, of so many `LANES`."""

_QUICK = ("floor", "log", "cos")
_ALONE = ("fabs", "sqrt", "ceil", "exp", "sin", "tan", "tanh", "erf", "atan")
_PAIRS = ("pow", "fmod", "atan2", "copysign", "fmin", "fmax")
"""Functions for all lanes at once, and lane by lane of one number and of two."""

_NUMBER = r"-?[\d.]+(?:e[-+]?\d+)?"
_TERM = r"\(\*c[rs]\+\+\)|\w+"
_REWRITTEN = (
    (rf"(?<!\w)({'|'.join(_QUICK)})\(", r"quick_\1("),
    (rf"(?<!\w)({'|'.join((*_ALONE, *_PAIRS))})\(", r"lanes_\1("),
    (rf"\(({_TERM})\?([^:()]+):0\)", r"IF(\1, \2)"),
    (r"\((\w+)\?(\w+):(\w+)\)", r"EITHER(\1, \2, \3)"),
    (rf"\(({_TERM})(<=|<|==|!=)({_TERM})\);", r"TRUTH(\1\2\3);"),
    (r"(?<!if )\(\s*!\s*(\*c[rs]\+\+|\w+)\s*\)", r"TRUTH(\1 == 0)"),
    (r"\((\w+)&&(\w+)\)", r"TRUTH((\1 != 0) & (\2 != 0))"),
    (r"\((\w+)\|\|(\w+)\)", r"TRUTH((\1 != 0) | (\2 != 0))"),
    (rf"(?<!\b[ijk])(?<!\])= ?({_NUMBER});", r"= EACH(\1);"),
    (rf"(casadi_fill\([^;]*, )({_NUMBER})\)", r"\1EACH(\2))"),
    (r"if \((.+) != 0\) \{", r"if (any_of(\1)) {"),
    (r"arg\[0\] \? casadi_to_int\(\*arg\[0\]\) : 0", "any_of(*arg[0])"),
    (r"return x<0 \? -1 : x>0 \? 1 : x;", "return TRUTH(x > 0) - TRUTH(x < 0) + IF(TRUTH(x != x), x);"),
    (r"\{0\.\};", "{{0.}};"),
    (r"\bdouble\b", "lanes"),
)
"""What means something else for vectors: choices, comparisons, and numbers that stand for a whole vector."""


def in_lanes(text: str, lanes: int) -> str:
    """C of CasADi's functions, as `functions_text` writes it, with a vector wherever it has a double."""
    for found, written in _REWRITTEN:
        text = re.sub(found, written, text)
    header = _HEADER.read_text("utf-8")
    header += "".join(f"LANE_BY_LANE({name})\n" for name in _ALONE)
    header += "".join(f"LANE_BY_LANE_2({name})\n" for name in _PAIRS)
    return f"#define LANES {lanes}\n{header}{text}"


@cache
def processor() -> tuple[int, str | None]:
    """Lanes worth their while on this machine, and the level of its processor as compilers name it."""
    try:
        flags = set(Path("/proc/cpuinfo").read_text("utf-8").partition("flags")[2].partition("\n")[0].split())
    except OSError:
        flags = set()
    if {"avx512f", "avx512dq", "avx512vl", "avx512bw", "avx512cd"} <= flags:
        return 8, "x86-64-v4"
    return 4, "x86-64-v3" if {"avx2", "fma", "bmi2"} <= flags else None


def runs_here(level: str | None) -> bool:
    """Whether this machine's processor is of a level at least."""
    return level is None or level <= (processor()[1] or "")
