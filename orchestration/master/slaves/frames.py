"""What processes tell each other, in frames of plain data: nothing in them is ever run.

An FMU can write into every descriptor of its process. So each frame tells its length and has checksums, and
what it holds is rebuilt from numbers, texts, lists and classes that the receiver names. A process that holds
FMUs is sent questions by one that does not, and only the latter's own bytes may be a pickle.
"""

from __future__ import annotations

import builtins
import json
import os
import select
import struct
import sys
import time
import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus import errors
from warmlink.fmus.errors import InputError
from warmlink.orchestration.master.slaves.slave import SlaveError

_MARK = 0x774C3146
_HEADER = struct.Struct("<IQI")  # mark, length of the content, its checksum; then the checksum of these
_CHECK = struct.Struct("<I")
_SIZE = _HEADER.size + _CHECK.size
_MOST_BYTES = 1 << 36
_CALL = struct.Struct("<cBI")
_NOTHING, _NUMBERS, _CALLED, _REST = b"0", b"n", b"c", b"r"

HIGH = 600
"""Least number of a descriptor that FMUs hardly hit that write into any, mostly below 256."""

TRANSFER_SECONDS = 60.0
"""For the rest of a frame that has begun to arrive."""


class DamagedError(Exception):
    """What arrived is no frame, or not the one that was sent."""


def out_of_reach(descriptor: int) -> int:
    """Give a descriptor of the same file with a high number, in place of this one, where there are such."""
    if sys.platform == "win32":
        return descriptor
    import fcntl

    with suppress(OSError, ValueError):  # the process may not have that many
        moved = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, HIGH)
        os.close(descriptor)
        return moved
    return descriptor


class Frames:
    """One end of a pipe between two processes; frames may hold instances of `classes`, which are dataclasses.

    Sending raises OSError where the other end is gone, receiving EOFError.
    """

    def __init__(self, pipe: Connection, classes: tuple[type, ...] = ()) -> None:
        self.pipe = pipe
        self._classes = {each.__name__: each for each in classes}
        self._poll: Any = None
        if sys.platform != "win32":
            self.pipe = Connection(out_of_reach(os.dup(pipe.fileno())))
            pipe.close()
            self._number = self.pipe.fileno()
            self._poll = select.poll()
            self._poll.register(self._number, select.POLLIN)

    def fileno(self) -> int:
        """Descriptor of the pipe, as `multiprocessing.connection.wait` wants it."""
        return self.pipe.fileno()

    def close(self) -> None:
        """Close this end."""
        self.pipe.close()

    def send(self, content: object) -> None:
        """Send numbers, texts, bytes, arrays of doubles, collections and dataclasses of them, exceptions."""
        if content is None:
            self._send(_NOTHING)
        elif type(content) is list and set(map(type, content)) == {float}:
            self._send(_NUMBERS + array("d", content).tobytes())
        else:
            self._send(_REST + packed(content))

    def send_call(self, what: int, of: int, numbers: Sequence[float]) -> None:
        """Send what the receiver gets as a tuple: two whole numbers, below 256 and 2**32, and a list."""
        self._send(_CALL.pack(_CALLED, what, of) + array("d", numbers).tobytes())

    def _send(self, body: bytes) -> None:
        head = _HEADER.pack(_MARK, len(body), zlib.crc32(body))
        whole = head + _CHECK.pack(zlib.crc32(head)) + body
        if sys.platform == "win32":
            self.pipe.send_bytes(whole)
            return
        written = os.write(self._number, whole)
        while written < len(whole):
            written += os.write(self._number, memoryview(whole)[written:])

    def poll(self, seconds: float) -> bool:
        """Tell whether anything arrives within so many s."""
        if self._poll is None:
            return self.pipe.poll(seconds)
        return bool(self._poll.poll(max(0.0, 1e3 * seconds)))

    def receive(self) -> Any:
        """Give the next content, which has begun to arrive; DamagedError where that is none."""
        if sys.platform == "win32":
            whole = self.pipe.recv_bytes()
            head, body = whole[:_SIZE], whole[_SIZE:]
        else:
            head, body = self._exactly(_SIZE), b""
        if len(head) < _SIZE or zlib.crc32(head[: _HEADER.size]) != _CHECK.unpack(head[_HEADER.size :])[0]:
            raise DamagedError
        mark, length, checksum = _HEADER.unpack(head[: _HEADER.size])
        if mark != _MARK or not 1 <= length <= _MOST_BYTES:
            raise DamagedError
        body = body or self._exactly(length)
        if len(body) != length or zlib.crc32(body) != checksum:
            raise DamagedError
        try:
            kind = body[:1]
            if kind == _NOTHING:
                return None
            if kind == _NUMBERS:
                return array("d", body[1:]).tolist()
            if kind == _CALLED:
                return (*_CALL.unpack_from(body)[1:], array("d", body[_CALL.size :]).tolist())
            return unpacked(body[1:], self._classes)
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError) as fault:
            raise DamagedError from fault

    def _exactly(self, size: int) -> bytes:
        """Read so many bytes; DamagedError where they do not come."""
        found = os.read(self._number, size)
        if len(found) == size:
            return found
        end, parts = time.monotonic() + TRANSFER_SECONDS, [found]
        left = size - len(found)
        while left and parts[-1]:
            if not self.poll(end - time.monotonic()):
                raise DamagedError
            parts.append(os.read(self._number, min(left, 1 << 20)))
            left -= len(parts[-1])
        if left:
            raise EOFError
        return b"".join(parts)


def packed(content: object) -> bytes:
    """Give plain data as bytes: JSON, and behind it what that counts up: bytes and arrays of doubles."""
    blobs: list[bytes] = []
    text = json.dumps(_plain(content, blobs), separators=(",", ":")).encode("utf-8")
    sizes = struct.pack(f"<I{1 + len(blobs)}Q", len(blobs), len(text), *map(len, blobs))
    return b"".join((sizes, text, *blobs))


def unpacked(data: bytes, classes: Mapping[str, type]) -> Any:
    """Give what was packed; ValueError, KeyError or TypeError where it was not, or of other classes."""
    (count,) = struct.unpack_from("<I", data)
    try:
        sizes = struct.unpack_from(f"<{1 + count}Q", data, 4)
    except struct.error as fault:
        raise ValueError from fault
    at = 4 + 8 * (1 + count)
    pieces = []
    for size in sizes:
        pieces.append(data[at : at + size])
        at += size
    return _rebuilt(json.loads(pieces[0]), pieces[1:], classes)


def _plain(value: object, blobs: list[bytes]) -> Any:
    """Give a value as JSON has it; what that has not is a list that begins with what it is."""
    if value is None or isinstance(value, bool | str | int | float):
        # Of their own classes, as NumPy's floats are, they would not all be numbers of JSON.
        return value if type(value) in _AS_THEY_ARE else _own(value)
    if isinstance(value, list | tuple | frozenset | set):
        kind = next(each.__name__ for each in (list, tuple, frozenset, set) if isinstance(value, each))
        return [kind, [_plain(each, blobs) for each in value]]
    if isinstance(value, Mapping):
        return ["dict", [[_plain(key, blobs), _plain(held, blobs)] for key, held in value.items()]]
    if isinstance(value, np.generic):
        return _own(value.item())
    if isinstance(value, bytes | bytearray | memoryview):
        blobs.append(bytes(value))
        return ["bytes", len(blobs) - 1]
    if isinstance(value, np.ndarray):
        blobs.append(np.ascontiguousarray(value, dtype=np.float64).tobytes())
        return ["array", len(blobs) - 1, list(value.shape)]
    if isinstance(value, Path):
        return ["Path", str(value)]
    if is_dataclass(value) and not isinstance(value, type):
        held = {each.name: _plain(getattr(value, each.name), blobs) for each in fields(value) if each.init}
        return ["class", type(value).__name__, held]
    if isinstance(value, BaseException):
        kind, given = _as_known(value)
        return ["exception", kind, [_plain(each, blobs) for each in given]]
    raise TypeError(f"{type(value).__name__} values do not go to another process")


_AS_THEY_ARE = frozenset((type(None), bool, str, int, float))


def _own(value: Any) -> Any:
    return next(each(value) for each in (bool, int, float, str) if isinstance(value, each))


def _as_known(fault: BaseException) -> tuple[str, tuple[Any, ...]]:
    """Give an exception's class, as the receiver knows it, and what that is made of."""
    kind, given = type(fault), fault.args
    if isinstance(fault, InputError):
        return kind.__name__ if _made_of_text(kind) else "InputError", (Exception.__str__(fault),)
    if isinstance(fault, SlaveError):
        return "SlaveError", fault.__reduce__()[1]
    if kind.__module__ == "builtins" and all(type(each) in _AS_THEY_ARE for each in given):
        more = (fault.filename,) if isinstance(fault, OSError) and isinstance(fault.filename, str) else ()
        return kind.__name__, (*given[:2], *more) if more else given
    return "RuntimeError", (f"{kind.__name__}: {fault}",)


def _made_of_text(kind: type) -> bool:
    return getattr(errors, kind.__name__, None) is kind and kind.__init__ is InputError.__init__


def _rebuilt(value: Any, blobs: list[bytes], classes: Mapping[str, type]) -> Any:
    if not isinstance(value, list):
        return value
    kind, *held = value
    return _MAKERS[kind](held, blobs, classes)


def _collection(make: Callable[[Any], Any]) -> Callable[..., Any]:
    return lambda held, blobs, classes: make(_rebuilt(each, blobs, classes) for each in held[0])


def _instance(held: Any, blobs: list[bytes], classes: Mapping[str, type]) -> Any:
    name, values = held
    return classes[name](**{key: _rebuilt(each, blobs, classes) for key, each in values.items()})


def _exception(held: Any, blobs: list[bytes], classes: Mapping[str, type]) -> BaseException:
    name, given = held[0], [_rebuilt(each, blobs, classes) for each in held[1]]
    kind = SlaveError if name == "SlaveError" else getattr(errors, name, None) or getattr(builtins, name)
    if not issubclass(kind, BaseException):
        raise TypeError(name)
    return kind(*given)


_MAKERS: dict[str, Callable[..., Any]] = {
    **{each.__name__: _collection(each) for each in (list, tuple, frozenset, set)},
    "dict": lambda held, *rest: {_rebuilt(k, *rest): _rebuilt(v, *rest) for k, v in held[0]},
    "bytes": lambda held, blobs, classes: blobs[held[0]],
    "array": lambda held, blobs, classes: np.frombuffer(blobs[held[0]]).reshape(held[1]).copy(),
    "Path": lambda held, blobs, classes: Path(held[0]),
    "class": _instance,
    "exception": _exception,
}
