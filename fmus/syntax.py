"""What reading Python source as a syntax tree needs."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """To be put around `ast.parse`.

    CPython before 3.11.8 counts the depth of all parses in one place (its issue 106905): where a garbage
    collection falls into one and a finaliser parses too, sound source ends in a SystemError.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
