"""The sentence that a user gets."""

import pickle

import pytest

from warmlink.fmus.errors import InputError, MissingExtraError


@pytest.mark.parametrize("given", ["a\nb", "a\x85b", "a\x0cb", "a\x01b", "a\u2028b"])
def test_it_is_one_line_whatever_was_given(given: str) -> None:
    told = str(InputError(f"{given}: no such name"))
    assert told.isprintable()
    assert len(told.splitlines()) == 1
    assert str(pickle.loads(pickle.dumps(InputError(given)))) == str(InputError(given))


def test_what_is_printable_stays_as_it_is() -> None:
    assert str(InputError("5 µm × 2")) == "5 µm × 2"
    assert 'pip install "warmlink[fea]"' in str(MissingExtraError("a rod", "fea"))
