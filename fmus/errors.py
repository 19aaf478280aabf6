"""Errors that a user can correct."""


class InputError(ValueError):
    """Bad input: the message says what is wrong, where, its value and unit, and the remedy.

    The commands catch it, print its one sentence, and end with exit code 2. Characters that cannot be
    printed, such as a line break in a name, are escaped, so that the sentence is always one line.
    """

    def __str__(self) -> str:
        told = super().__str__()
        if told.isprintable():
            return told
        return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in told)


class NoRoomError(InputError):
    """The disk is full, which does not mean that the input was wrong."""


class MissingExtraError(InputError):
    """An optional part is not installed; the message gives the command that installs it."""

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(f'{purpose} needs an optional part: pip install "warmlink[{extra}]"')

    def __reduce__(self) -> tuple[type[InputError], tuple[str, ...]]:
        """Go to another process as the sentence that it is."""
        return InputError, self.args
