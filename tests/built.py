"""What tests compile in C, kept from session to session as the objects of FMUs are."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.cache import kept
from warmlink.fmus.packaging.native.compile import _version, compilers, platforms_named
from warmlink.fmus.packaging.native.library import loaded

Ended = subprocess.CompletedProcess[str]


def built(
    command: Sequence[str], made_from: object, target: Path, judge: Callable[[Ended], None] | None = None
) -> Path:
    """File that a compiler makes in the file's folder, unless it has made it from the same things before.

    `judge` looks at what the compiler said; by default it must not have failed.
    """

    def make() -> bytes:
        done = subprocess.run(
            [*command, "-o", target.name], cwd=target.parent, capture_output=True, text=True
        )
        if judge is None:
            done.check_returncode()
        else:
            judge(done)
        return target.read_bytes()

    content = kept("tests", (tuple(command), _version((command[0],)), made_from), make)
    target.write_bytes(content)
    target.chmod(0o755)
    return target


def call_of(text: str) -> Any:
    """Function `call` of C, to be called from Python; the test is skipped where there is no compiler."""
    try:
        (compiler,) = compilers(platforms_named(None))
    except InputError as fault:
        pytest.skip(str(fault))
    flags = tuple(each for each in compiler.flags if "visibility" not in each)
    return loaded(replace(compiler, flags=flags).library({"tried.c": text}, "tried")).call
