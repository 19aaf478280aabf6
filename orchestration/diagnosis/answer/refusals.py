"""Answers that a machine or its measurements do not allow: a sentence each says why."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from warmlink.fmus.errors import InputError

Answered = TypeVar("Answered")


class Refusals(dict[str, str]):
    """Why an answer cannot be given, by its name."""

    def asked(self, name: str, answer: Callable[[], Answered]) -> Answered | None:
        """The answer; None if it cannot be given, and then the reason is noted."""
        try:
            return answer()
        except InputError as fault:
            self[name] = str(fault)
            return None
