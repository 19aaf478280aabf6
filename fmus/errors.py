"""The error that a user can mend."""


class InputError(ValueError):
    """What was given cannot be used: the message says what, where, its value and unit, and the remedy.

    Programs catch it to end with exit code 2 and that one sentence. What is not printable in it, as a line
    break in a name, is shown as Python writes it, so that it is one line whatever was given.
    """

    def __str__(self) -> str:
        told = super().__str__()
        if told.isprintable():
            return told
        return "".join(each if each.isprintable() else ascii(each)[1:-1] for each in told)


class NoRoomError(InputError):
    """The disk takes nothing more, which says nothing about what was given."""


class MissingExtraError(InputError):
    """An optional part is not installed; the message gives the command that installs it."""

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(f'{purpose} needs an optional part: pip install "warmlink[{extra}]"')

    def __reduce__(self) -> tuple[type[InputError], tuple[str, ...]]:
        """Go to another process as the sentence that it is."""
        return InputError, self.args
