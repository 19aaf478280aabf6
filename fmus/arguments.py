"""What a caller gave, as the caller wrote it: `--stop soon` on the command line, `stop='soon'` in Python."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Integral
from os import PathLike
from pathlib import Path

from warmlink.fmus.errors import InputError

_options: Mapping[str | tuple[str, type], str] | None = None
_quoted: Callable[[str], str] = str
_line = ""


@contextmanager
def speaking_of_options(
    names: Mapping[str | tuple[str, type], str], quoted: Callable[[str], str] = str, line: str = ""
) -> Iterator[None]:
    """Let sentences speak of a command's options meanwhile, as while a command runs.

    Parameters
    ----------
    names : option of each argument that is not called alike, as `--mismatch` of `mismatches`; by name and
        type if values of this type have an option of their own
    quoted : gives `NAME=VALUE` as one word of a command
    line : the command line, without what does not change its results
    """
    global _options, _quoted, _line
    before = _options, _quoted, _line
    _options, _quoted, _line = names, quoted, line
    try:
        yield
    finally:
        _options, _quoted, _line = before


def command_given() -> str:
    """The command line that is at work, to be copied; empty if a program called a function."""
    return _line


def argument(name: str, *value: object) -> str:
    """Name an argument, with its value where one is given, for a sentence of an error or a remark.

    Parameters
    ----------
    name : of the argument of the Python function, as `jobs`; of a field of what is given as one, as
        `long_run.resume`
    value : at most one; a mapping is an option for each of its entries, `--assume torque=0`
    """
    if _options is not None:
        option = _options.get(name, f"--{name.rpartition('.')[2].strip('_').replace('_', '-')}")
        if value and isinstance(value[0], Path):
            option = _options.get((name, Path), option)
        if value and isinstance(value[0], Mapping):
            return " ".join(f"{option} {_quoted(f'{key}={each}')}" for key, each in value[0].items())
        return " ".join([option, *(f"{each:g}" if isinstance(each, float) else str(each) for each in value)])
    return f"{name}={str(value[0]) if isinstance(value[0], Path) else value[0]!r}" if value else f"`{name}`"


def path_given(name: str, value: object) -> Path:
    """The path that an argument gives; InputError if it gives none."""
    if not isinstance(value, str | PathLike):
        raise InputError(f"{argument(name, value)}: is no path; give the path of a file")
    return Path(value)


def count_given(name: str, value: object, least: int, most: int, of: str) -> int:
    """The whole number of something that an argument gives; InputError if it is none between those two."""
    count = int(value) if isinstance(value, Integral) and not isinstance(value, bool) else least - 1
    if not least <= count <= most:
        told = f"{argument(name, value)}: not a number of {of}"
        raise InputError(f"{told}; give a whole number from {least} to {most}")
    return count
