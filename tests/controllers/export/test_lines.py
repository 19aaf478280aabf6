"""Statements are divided where nothing else is meant by it, and comments cannot end early."""

import re

import pytest

from warmlink.controllers.export.c_helpers import comment
from warmlink.controllers.export.lines import WIDTH, wrapped

SUM = "growth = " + " + ".join(f"row[{i}] * larger(mode[{i}], none)" for i in range(12)) + ";"


def test_a_short_statement_stays_on_its_line() -> None:
    assert wrapped("    x = a + b;", "        ") == ["    x = a + b;"]


@pytest.mark.parametrize("text", [SUM, SUM.replace("growth =", "growth :=")])
def test_a_long_statement_goes_on_indented_and_says_the_same(text: str) -> None:
    lines = wrapped(text, "        ")
    assert len(lines) > 2
    assert max(map(len, lines)) <= WIDTH
    assert all(line.startswith("        ") for line in lines[1:])
    assert not any(line.endswith(" ") for line in lines)
    assert re.sub(r"\s", "", "".join(lines)) == re.sub(r"\s", "", text)


def test_what_is_longer_than_a_line_is_not_cut() -> None:
    name = "n" * (WIDTH + 20)
    assert wrapped(f"x = {name} + 1;", "  ") == ["x =", f"  {name}", "  + 1;"]
    assert wrapped(f"{name} + 1;", "  ") == [name, "  + 1;"]


def test_a_line_may_be_full() -> None:
    assert len(wrapped("a " + "n" * (WIDTH - 2), "  ")) == 1
    assert len(wrapped("a " + "n" * (WIDTH - 1), "  ")) == 2


def test_an_argument_stays_with_its_sign_wherever_a_line_ends() -> None:
    for room in range(12):
        lines = wrapped("f" * (WIDTH - room) + "(IN := 1);", "  ")
        assert not any(line.lstrip().startswith(":=") for line in lines)


def test_a_comment_is_one_comment_whatever_it_holds() -> None:
    (line,) = comment("ends here */ int x; /* or not")
    assert line == "/* ends here  int x; /* or not */"
    many = comment("word " * 60)
    assert len(many) > 1
    assert max(map(len, many)) <= WIDTH
    assert "".join(many).count("*/") == 1
