"""Ctrl-C is noted until what runs is between two steps, and raised at once where it may be given up."""

from __future__ import annotations

import os
import signal

import pytest

from warmlink.orchestration.master.slaves import under_way

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def test_the_first_is_noted_and_the_second_raised() -> None:
    with under_way.interruption():
        press()
        assert under_way.asked()
        with pytest.raises(KeyboardInterrupt):
            press()
    assert not under_way.asked()


def test_what_may_be_given_up_is_given_up_at_once() -> None:
    with under_way.interruption(lambda: True), pytest.raises(KeyboardInterrupt):
        press()


def test_afterwards_it_is_as_it_was() -> None:
    before = signal.getsignal(signal.SIGINT)
    with under_way.interruption():
        pass
    assert signal.getsignal(signal.SIGINT) is before
