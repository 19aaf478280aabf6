"""Faults of a guarded run reach whoever asked for it, as what they are."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import pytest

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.master.guard import guarded

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="runs are guarded on Linux")


class Unportable(Exception):  # noqa: N818
    """As lxml's errors are, where a package has exceptions pickled with their causes."""

    def __reduce__(self) -> Any:
        raise TypeError("cannot be pickled")


def caused() -> None:
    try:
        raise Unportable
    except Unportable as cause:
        raise InputError("x.fmu: not well-formed; make it anew") from cause


def missing() -> None:
    raise MissingExtraError("compiled stepping", "studies")


@pytest.mark.parametrize(("work", "word"), [(caused, "make it anew"), (missing, "pip install")])
def test_bad_input_is_bad_input_on_the_other_side_too(work: Callable[[], None], word: str) -> None:
    pickling = pytest.importorskip("tblib.pickling_support")
    pickling.install(InputError)
    with pytest.raises(InputError, match=word):
        guarded(lambda line: work())  # type: ignore[arg-type,return-value,func-returns-value]
