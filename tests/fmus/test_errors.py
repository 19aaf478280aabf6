"""A refusal is one line, whatever was written in the file."""

import pytest

from warmlink.fmus.errors import InputError


@pytest.mark.parametrize("unit", ["m" * 5000, "µ" * 301, "rad^" * 1250])
def test_a_word_of_thousands_of_characters_is_shortened(unit: str) -> None:
    told = str(InputError(f"a.csv: column 'speed [{unit}]' is no speed; write rad/s"))
    assert len(told) < 200
    assert told.startswith(f"a.csv: column 'speed [{unit[:60]}")
    assert told.endswith("... is no speed; write rad/s")


def test_a_path_is_told_whole() -> None:
    told = f"/{'/'.join(['folder'] * 40)}/a.csv: there is no such file"
    assert str(InputError(told)) == told


def test_line_breaks_are_escaped() -> None:
    assert str(InputError("a\nb.csv: no")) == r"a\nb.csv: no"
