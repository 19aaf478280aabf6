"""The former place of the public functions: `import warmlink as wl` has them now."""

from __future__ import annotations

from inspect import isfunction
from typing import Any

import warmlink
from warmlink.orchestration.deprecation import deprecated

__all__ = [name for name in warmlink.__all__ if name != "__version__"]


def __getattr__(name: str) -> Any:
    """Load the object of this name; a function warns when it is called."""
    if name not in __all__:
        raise AttributeError(f"warmlink.orchestration.api has no {name}; import warmlink as wl")
    found = getattr(warmlink, name)
    if not isfunction(found):
        return found
    return deprecated(f"warmlink.orchestration.api.{name}", f"warmlink.{name}", "0.2.0")(found)


def __dir__() -> list[str]:
    return __all__
