"""The one place that imports scikit-fem, so that its absence is said in one sentence."""

from __future__ import annotations

from types import ModuleType

from warmlink.fmus.errors import MissingExtra


def scikit_fem() -> ModuleType:
    """Return the module `skfem`.

    Raises
    ------
    MissingExtra
        scikit-fem is not installed.
    """
    try:
        import skfem
    except ImportError as error:
        raise MissingExtra("the 3-D finite-element model", "fea") from error
    return skfem
