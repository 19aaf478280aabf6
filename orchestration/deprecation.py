"""What goes in a later release, and what to use in its place."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def deprecated(name: str, replacement: str, removed_in: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a public function that still works and will be removed; each call warns its caller.

    Parameters
    ----------
    name : the function as its users call it
    replacement : what to use instead
    removed_in : the first release without the function
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            sentence = f"{name} will be removed in {removed_in}; use {replacement}"
            warnings.warn(sentence, DeprecationWarning, stacklevel=2)
            return function(*args, **kwargs)

        return called

    return decorate
