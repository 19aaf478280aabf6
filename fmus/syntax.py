"""Reading Python source as a syntax tree."""

import ast
import gc
from typing import Any


def parsed(source: str | bytes, mode: str = "exec") -> Any:
    """Syntax tree of a source, by `ast.parse` with no garbage collection meanwhile.

    CPython before 3.11.8 counts the depth of all parses in one place (its issue 106905): where a garbage
    collection falls into one and a finaliser parses too, sound source ends in a SystemError.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        return ast.parse(source, mode=mode)
    finally:
        if collecting:
            gc.enable()
