"""CasADi's C with vectors in place of numbers: several runs side by side in the lanes of a processor.

The vectors are those of gcc and clang. Every lane computes what the plain text computes, in the same order.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

_HEADER = """#include <math.h>
#include <string.h>
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef long long masks __attribute__((vector_size(8 * LANES)));
#define casadi_real lanes
#define casadi_nan EACH(NAN)
#define casadi_inf EACH(INFINITY)
#define EACH(number) ((lanes){0} + (number))
#define TRUTH(condition) __builtin_convertvector(-(condition), lanes)
#define IF(condition, value) ((lanes)((masks)((condition) != 0.0) & (masks)(value)))
/* Rounded by adding 1.5 2^52, and one less where that went up; larger numbers are whole as they are. */
static inline lanes lanes_floor(lanes x)
{
    const masks sign = (masks){0} + (-0x7fffffffffffffffLL - 1);
    lanes whole = (x + 0x1.8p52) - 0x1.8p52, size = (lanes)((masks)x & ~sign);
    masks small = size < 0x1p51;
    whole -= (lanes)((whole > x) & (masks)EACH(1));
    return (lanes)((((masks)whole | ((masks)x & sign)) & small) | ((masks)x & ~small));
}
#define LANE_BY_LANE(name) \\
    static inline lanes lanes_##name(lanes x) \\
    { double *each = (double *)&x; for (int i = 0; i < LANES; i++) each[i] = name(each[i]); return x; }
#define LANE_BY_LANE_2(name) \\
    static inline lanes lanes_##name(lanes x, lanes y) \\
    { for (int i = 0; i < LANES; i++) x[i] = name(x[i], y[i]); return x; }
"""

_NOISE = r"""
/* The two functions that noise needs for each reading; what they are not made for is done lane by lane. */
static int all_between(lanes x, double low, double high)
{
    int well = 1;
    for (int i = 0; i < LANES; i++)
        well &= x[i] >= low && x[i] <= high;
    return well;
}
/* x = 2^n m with m about 1, and log m = 2 artanh((m - 1) / (m + 1)) by its series. */
static lanes quick_log(lanes x)
{
    if (!all_between(x, 1e-300, 1e300))
        return lanes_log(x);
    masks n = ((masks)x - 0x3fe6a09e667f3bcdLL) >> 52;
    lanes m = (lanes)((masks)x - (n << 52)), s = (m - 1.0) / (m + 1.0), z = s * s, sum = EACH(1.0 / 25);
#pragma GCC unroll 16
    for (int k = 23; k > 1; k -= 2)
        sum = 1.0 / k + z * sum;
    lanes whole = __builtin_convertvector(n, lanes);
    return whole * 0x1.62e42feep-1 + (2.0 * s + (2.0 * s * z * sum + whole * 0x1.a39ef35793c76p-33));
}
/* x = n pi / 2 + r, and the series of the cosine or the sine of r. */
static lanes quick_cos(lanes x)
{
    if (!all_between(x, -1e3, 1e3))
        return lanes_cos(x);
    lanes whole = floor(x * 0x1.45f306dc9c883p-1 + 0.5);
    lanes r = x - whole * 0x1.921fb544p+0 - whole * 0x1.0b4611a626331p-34, z = r * r;
    lanes c = EACH(1), s = EACH(1);
#pragma GCC unroll 16
    for (int k = 18; k > 0; k -= 2) {
        c = 1.0 - z * (1.0 / (k * (k - 1))) * c;
        s = 1.0 - z * (1.0 / (k * (k + 1))) * s;
    }
    masks n = __builtin_convertvector(whole, masks), odd = -(n & 1);
    return (lanes)((((masks)c & ~odd) | ((masks)(r * s) & odd)) ^ (((n + 1) & 2) << 62));
}
#undef log
#undef cos
#define log quick_log
#define cos quick_cos
"""

_FUNCTIONS = ("fabs", "sqrt", "ceil", "exp", "log", "sin", "cos", "tan", "tanh", "erf", "atan")
_OF_TWO = ("pow", "fmod", "atan2", "copysign", "fmin", "fmax")

_NUMBER = r"-?[\d.]+(?:e[-+]?\d+)?"
_TERM = r"\(\*c[rs]\+\+\)|\w+"
_REWRITTEN = (
    (rf"\(({_TERM})\?([^:()]+):0\)", r"IF(\1, \2)"),
    (rf"\(({_TERM})(<=|<|==|!=)({_TERM})\);", r"TRUTH(\1\2\3);"),
    (r"(?<!if )\(\s*!\s*(\*c[rs]\+\+|\w+)\s*\)", r"TRUTH(\1 == 0)"),
    (r"\((\w+)&&(\w+)\)", r"TRUTH((\1 != 0) & (\2 != 0))"),
    (r"\((\w+)\|\|(\w+)\)", r"TRUTH((\1 != 0) | (\2 != 0))"),
    (rf"(?<!\b[ijk])(?<!\])= ?({_NUMBER});", r"= EACH(\1);"),
    (rf"(casadi_fill\([^;]*, )({_NUMBER})\)", r"\1EACH(\2))"),
    (r"return x<0 \? -1 : x>0 \? 1 : x;", "return TRUTH(x > 0) - TRUTH(x < 0) + IF(TRUTH(x != x), x);"),
    (r"\{0\.\};", "{{0.}};"),
    (r"\bdouble\b", "lanes"),
)
"""What means something else for vectors: choices, comparisons, and numbers that stand for a whole vector."""


def in_lanes(text: str, lanes: int) -> str:
    """C of CasADi's functions, as `functions_text` writes it, with a vector wherever it has a double."""
    for found, written in _REWRITTEN:
        text = re.sub(found, written, text)
    functions = "#define floor lanes_floor\n" + "".join(
        f"{macro}({name})\n#define {name} lanes_{name}\n"
        for macro, names in (("LANE_BY_LANE", _FUNCTIONS), ("LANE_BY_LANE_2", _OF_TWO))
        for name in names
    )
    return f"#define LANES {lanes}\n{_HEADER}{functions}{_NOISE}{text}"


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
