"""Ctrl-C is noted until a watch is between two rows, and raised at once where what runs may be given up."""

from __future__ import annotations

import os
import signal

import pytest

from warmlink.orchestration.watch.ending import Ending

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def test_the_first_is_noted_and_the_second_raised() -> None:
    ending = Ending(lambda: False)
    with ending.noted():
        press()
        assert ending.asked
        with pytest.raises(KeyboardInterrupt):
            press()


def test_what_may_be_given_up_is_given_up_at_once() -> None:
    ending = Ending(lambda: True)
    with ending.noted(), pytest.raises(KeyboardInterrupt):
        press()
    assert ending.asked


def test_afterwards_it_is_as_it_was() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Ending(lambda: False).noted():
        pass
    assert signal.getsignal(signal.SIGINT) is before
