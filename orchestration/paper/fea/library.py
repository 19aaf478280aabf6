"""The one place that imports scikit-fem, so that its absence is said in one sentence."""

from __future__ import annotations

from types import ModuleType

from warmlink.fmus.errors import MissingExtraError


def scikit_fem() -> ModuleType:
    """Return the module `skfem`, or say that it is missing."""
    try:
        import skfem
    except ImportError as error:
        raise MissingExtraError("the 3-D finite-element model", "fea") from error
    return skfem
