"""How many threads BLAS uses: one. Matrices are small here, and threads that share one wait in vain."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module

_USE_BLAS = ("numpy._core._multiarray_umath", "scipy.linalg._fblas")
_CALLED = ("scipy_openblas_{}64_", "scipy_openblas_{}", "openblas_{}64_", "openblas_{}")
"""Modules that were linked with an OpenBLAS, and what its functions are called there."""


def one_thread_from_the_start() -> None:
    """Let NumPy and SciPy, not imported yet, start no further threads, here and in child processes."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@contextmanager
def one_thread() -> Iterator[None]:
    """One thread for a while, where NumPy may have been imported long ago, as in a notebook.

    What computes without OpenBLAS, or hides its functions, goes on as before.
    """
    found = [(library, form, int(_call(library, form, "get")())) for library, form in _libraries()]
    for library, form, _ in found:
        _call(library, form, "set")(1)
    try:
        yield
    finally:
        for library, form, before in found:
            _call(library, form, "set")(before)


def _libraries() -> Iterator[tuple[ctypes.CDLL, str]]:
    """Each OpenBLAS in this process, and the form of its functions' names."""
    for module in _USE_BLAS:
        try:
            library = ctypes.CDLL(str(import_module(module).__file__))
        except (ImportError, OSError):  # inner modules of NumPy and SciPy, which may be called otherwise
            continue
        yield from ((library, form) for form in _CALLED if hasattr(library, form.format("set_num_threads")))


def _call(library: ctypes.CDLL, form: str, way: str) -> Callable[..., int]:
    return getattr(library, form.format(f"{way}_num_threads"))
