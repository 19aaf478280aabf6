"""Functions in C that every law may use, and comments."""

from __future__ import annotations

import textwrap

from warmlink.controllers.export.lines import WIDTH

HELPERS = {
    "larger": ("a", "b", "(a > b) ? a : b", "The larger of two numbers; b where one is NaN."),
    "smaller": ("a", "b", "(a < b) ? a : b", "The smaller of two numbers; b where one is NaN."),
    "ratio": (
        "a",
        "b",
        "((b > 0{f}) || (b < 0{f})) ? (a / b) : (b * 0{f})",
        "a / b; 0 where b is 0, and NaN where it is NaN.",
    ),
    "left": ("a", "b", "b - ((a + b) - a)", "What rounding leaves of b where it is added to a."),
    "root": ("a", "", "(a < 0{f}) ? 0{f} : {sqrt}(a)", "Square root; 0 below 0."),
}
"""Functions that every law may use: arguments, result and what it is."""


def helper(name: str, real: str, suffix: str) -> list[str]:
    """One of the functions, with a comment that says what it is, for the type of the law's numbers."""
    a, b, result, about = HELPERS[name]
    given = f"{real} {a}" + (f", {real} {b}" if b else "")
    told = result.replace("{f}", f".0{suffix}").replace("{sqrt}", f"sqrt{suffix}")
    return [*comment(about), f"static {real} {name}({given})", "{", f"    return {told};", "}", ""]


def comment(text: str) -> list[str]:
    """A comment."""
    return textwrap.wrap(f"/* {text.replace('*/', '')} */", WIDTH, subsequent_indent="   ")
