"""Sources are parsed without a garbage collection meanwhile, which is as it was afterwards."""

from __future__ import annotations

import ast
import gc

import pytest

from warmlink.fmus import syntax


@pytest.mark.parametrize("collecting", [True, False])
def test_collection_is_as_before(collecting: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    meanwhile: list[bool] = []
    parse = ast.parse
    monkeypatch.setattr(
        ast, "parse", lambda *given, **more: meanwhile.append(gc.isenabled()) or parse(*given, **more)
    )
    before = gc.isenabled()
    try:
        (gc.enable if collecting else gc.disable)()
        syntax.parsed("a = 1")
        with pytest.raises(SyntaxError):
            syntax.parsed("a = ")
        assert gc.isenabled() == collecting
        assert meanwhile == [False, False]
    finally:
        (gc.enable if before else gc.disable)()
