"""What processes tell each other arrives as it was sent, and what is no frame is known as such."""

from __future__ import annotations

import math
import os
import pickle
import sys
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warmlink.fmus.errors import InputError, MissingExtraError, NoRoomError
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.slaves.frames import HIGH, DamagedError, Frames
from warmlink.orchestration.master.slaves.slave import Calls, SlaveError, SlaveStatistics
from warmlink.orchestration.studies.case import Outcome

CLASSES = (Calls, CommunicationPoints, SlaveStatistics, Outcome)


@pytest.fixture
def ends() -> tuple[Frames, Frames]:
    one, other = Pipe()
    return Frames(one, CLASSES), Frames(other, CLASSES)


def through(ends: tuple[Frames, Frames], content: object) -> Any:
    ends[0].send(content)
    assert ends[1].poll(1.0)
    return ends[1].receive()


@pytest.mark.parametrize(
    "content",
    [
        None,
        [1.0, -0.0, math.inf, 5e-324],
        [1, 2.5, True, "ä\udc80", None],
        (1, (2, [3])),
        {"a": (1,), 2.5: frozenset(("x",)), None: {}},
        b"\0\xff" * 3,
        2**64,
        Path("a/b"),
        CommunicationPoints(0.0, 0.1, 3, (0.0, 0.1, 0.2, 0.3)),
        SlaveStatistics("a"),
        [Outcome(1.0, stopped="b: x"), Outcome()],
        ["list", "dict", "class"],
        [],
    ],
    ids=repr,
)
def test_content_arrives_as_it_was_sent(ends: tuple[Frames, Frames], content: object) -> None:
    found = through(ends, content)
    assert repr(found) == repr(content)
    assert type(found) is type(content)


def test_numbers_of_numpy_and_arrays_arrive(ends: tuple[Frames, Frames]) -> None:
    table = np.arange(6.0).reshape(2, 3)
    found = through(ends, [np.float64(1.5), np.int64(2), np.bool_(True), table])
    assert (found[:3], type(found[0]), type(found[2])) == ([1.5, 2, True], float, bool)
    np.testing.assert_array_equal(found[3], table)
    assert math.isnan(through(ends, [math.nan])[0])


@pytest.mark.parametrize(
    ("fault", "kind"),
    [
        (InputError("a: b"), InputError),
        (NoRoomError("full"), NoRoomError),
        (MissingExtraError("x", "studies"), InputError),
        (SlaveError("b", "crash", 2.0, "it died", "y"), SlaveError),
        (KeyboardInterrupt(), KeyboardInterrupt),
        (OSError(28, "No space left", "f"), OSError),
        (ZeroDivisionError("x"), ZeroDivisionError),
        (pickle.PicklingError("odd"), RuntimeError),
    ],
)
def test_exceptions_arrive(ends: tuple[Frames, Frames], fault: BaseException, kind: type) -> None:
    found = through(ends, fault)
    assert type(found) is kind
    assert str(fault) in str(found)


def test_calls_arrive_as_numbers(ends: tuple[Frames, Frames]) -> None:
    ends[0].send_call(2, 70000, (1.5, 2.5))
    assert ends[1].receive() == (2, 70000, [1.5, 2.5])


@pytest.mark.skipif(sys.platform == "win32", reason="a pipe of Windows has whole messages")
@pytest.mark.parametrize(
    "junk", [b"junk that is no frame", b"\0" * 64, pickle.dumps(print), b"\x80\x04", b"F1Lw" * 9]
)
def test_what_is_no_frame_is_known(ends: tuple[Frames, Frames], junk: bytes) -> None:
    os.write(ends[0].fileno(), junk)
    ends[0].send([1.0])
    with pytest.raises(DamagedError):
        ends[1].receive()


@pytest.mark.skipif(sys.platform == "win32", reason="a pipe of Windows has whole messages")
@pytest.mark.parametrize("place", [0, 5, 13, 17, 21, 40])
def test_a_frame_in_which_a_bit_is_turned_is_known(place: int) -> None:
    one, other = Pipe()
    sender, between = (Frames(each) for each in (one, other))
    sender.send(["text that is long enough", 1.5])
    content = bytearray(os.read(between.fileno(), 1 << 16))
    content[place] ^= 4
    os.write(sender.fileno(), content)
    with pytest.raises(DamagedError):
        between.receive()


def test_classes_that_the_receiver_does_not_name_are_refused() -> None:
    one, other = Pipe()
    sender, receiver = Frames(one, CLASSES), Frames(other)
    for content in (CommunicationPoints(0.0, 0.1, 3), ["x", Outcome()]):
        sender.send(content)
        with pytest.raises(DamagedError):
            receiver.receive()


def test_what_cannot_go_is_refused_where_it_is_sent(ends: tuple[Frames, Frames]) -> None:
    with pytest.raises(TypeError, match="object values do not go to another process"):
        ends[0].send([object()])


def test_a_closed_end_is_an_end(ends: tuple[Frames, Frames]) -> None:
    ends[0].close()
    with pytest.raises(EOFError):
        ends[1].receive()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has handles")
def test_pipes_are_out_of_reach_of_those_who_write_to_low_descriptors(ends: tuple[Frames, Frames]) -> None:
    assert all(each.fileno() >= HIGH for each in ends)
