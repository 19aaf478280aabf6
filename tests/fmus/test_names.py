"""What is said about a name that does not exist."""

from __future__ import annotations

import pytest

from warmlink.fmus.names import MOST_LISTED, instead, listed

LAWS = ("none", "analytic", "lag", "regression", "observer", "observer_drift")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("observr", "did you mean observer?"),
        ("OBSERVER", "did you mean observer?"),
        ("drift", "did you mean observer_drift?"),
        ("magic", "choose none, analytic, lag, regression, observer or observer_drift"),
        ("", "choose none, analytic, lag, regression, observer or observer_drift"),
    ],
)
def test_the_nearest_name_or_all_of_them(name: str, remedy: str) -> None:
    assert instead(name, LAWS) == remedy


def test_what_else_could_be_given_is_said_where_no_name_is_near() -> None:
    assert instead("magic", ("lag",), "or give a file") == "choose lag, or give a file"
    assert instead("lagg", ("lag",), "or give a file") == "did you mean lag?"
    assert instead("lag", (), "or give a file") == "there are none, or give a file"


def test_a_long_list_is_cut_and_begins_with_what_is_most_alike() -> None:
    many = [f"parameter_{i}" for i in range(500)] + ["joint_resistance"]
    sentence = instead("rest of the joint", many)
    assert sentence.startswith("choose joint_resistance, ")
    assert sentence.endswith(f" and {len(many) - MOST_LISTED} more")
    assert len(sentence) < 300


@pytest.mark.parametrize(
    ("names", "text"), [((), "none"), (("a",), "a"), (("a", "b"), "a and b"), (("a", "b", "c"), "a, b and c")]
)
def test_names_are_listed_as_in_a_sentence(names: tuple[str, ...], text: str) -> None:
    assert listed(names) == text
