"""A component as a WebAssembly module, which web pages run."""

from __future__ import annotations

from warmlink.fmus.component import Component
from warmlink.fmus.packaging.native.compile import BROWSER, compilers
from warmlink.fmus.packaging.native.fmu import native_sources


def browser_module(component: Component) -> bytes:
    """Module that imports nothing and exports the functions of `browser.c`.

    Its numbers are the native FMU's to the last bit, except where the two platforms' functions of
    mathematics (logarithm, exponential, sine) round differently.

    Raises
    ------
    InputError
        If zig is not installed.
    """
    sources, _ = native_sources(component, "browser")
    (compiler,) = compilers((BROWSER,))
    return compiler.library(sources, component.name)
