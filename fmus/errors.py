"""Errors that a user can correct."""

from __future__ import annotations

import re
from collections.abc import Iterable

_LONG_WORD, _SHOWN = re.compile(r"\S{300,}?(?=[:;,]?(?:\s|$))"), 80
"""A word that no reader wants to see whole, as a unit of 5000 characters, and how much of it is shown."""


class InputError(ValueError):
    """Bad input: the message says what is wrong, where, its value and unit, and the remedy.

    The commands catch it, print its one sentence, and end with exit code 2. Characters that cannot be
    printed, such as a line break in a name, are escaped, so that the sentence is always one line, and words
    of 300 characters and more are shortened.
    """

    def __str__(self) -> str:
        told = _LONG_WORD.sub(lambda found: f"{found[0][:_SHOWN]}...", super().__str__())
        if told.isprintable():
            return told
        return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in told)


def in_one_line(fault: BaseException) -> str:
    """What an error of anybody's code says, shortened, for a part of a sentence."""
    return " ".join(str(fault).split())[:300]


class NoRoomError(InputError):
    """The disk is full, which does not mean that the input was wrong."""


MOST_SENTENCES = 10
"""Mistakes that are told at once."""


class SeveralError(InputError):
    """Several mistakes in one input: a sentence for each, in a line of its own."""

    def __str__(self) -> str:
        return "\n".join(str(InputError(sentence)) for sentence in self.args)


def refusal(sentences: Iterable[str]) -> InputError:
    """Error to be raised for some mistakes, each told once: at most ten sentences, and how many more."""
    told = list(dict.fromkeys(line for sentence in sentences for line in sentence.split("\n")))
    more = len(told) - MOST_SENTENCES
    if len(told) == 1:
        return InputError(told[0])
    return SeveralError(*told[:MOST_SENTENCES], *([f"and {more} more"] if more > 0 else []))


class MissingExtraError(InputError):
    """An optional part is not installed; the message gives the command that installs it."""

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(f'{purpose} needs an optional part: pip install "warmlink[{extra}]"')

    def __reduce__(self) -> tuple[type[InputError], tuple[str, ...]]:
        """Go to another process as the sentence that it is."""
        return InputError, self.args
