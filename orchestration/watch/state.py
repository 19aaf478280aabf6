"""What a watcher knows as one checksummed line of JSON, so that a restart goes on bit for bit."""

from __future__ import annotations

import base64
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import fresh_file, stamped, unstamped
from warmlink.orchestration.watch.combining import Scatter
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.filter.shadow import Shadow
from warmlink.orchestration.watch.learning import SoundPart
from warmlink.orchestration.watch.sequential import Limits, Sequential
from warmlink.orchestration.watch.sources.protocol import FilePlace
from warmlink.orchestration.watch.ticks import Gatherer, Tick
from warmlink.orchestration.watch.watcher import SHADOW_KEPT, Moment, Standing, Watcher, twin_of

_KINDS = {each.__name__: each for each in (Tick, ShadowNoise, Scatter, SoundPart, Limits, Standing, Moment)}


class Beside(NamedTuple):
    """What a watch keeps in its state beside filter and test.

    Attributes
    ----------
    events : that were told, as JSON
    rows : that were read
    doubtful : cells and times of them that held no credible number
    place : in the file that they came from; None if their source cannot go back
    """

    events: list[dict[str, Any]]
    rows: int
    doubtful: int
    place: FilePlace | None


def encoded(value: Any) -> Any:
    """A value as JSON has it; arrays byte for byte."""
    if isinstance(value, np.ndarray):
        raw = np.ascontiguousarray(value, dtype=float)
        return {"array": base64.b64encode(raw.tobytes()).decode(), "shape": list(value.shape)}
    if isinstance(value, np.generic):
        return value.item()
    if is_dataclass(value) and type(value).__name__ in _KINDS:
        return {
            "kind": type(value).__name__,
            "of": {f.name: encoded(getattr(value, f.name)) for f in fields(value)},
        }
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {"kind": type(value).__name__, "of": {n: encoded(v) for n, v in value._asdict().items()}}
    if isinstance(value, Mapping):
        return {"map": {name: encoded(each) for name, each in value.items()}}
    if isinstance(value, tuple):
        return {"tuple": [encoded(each) for each in value]}
    if isinstance(value, list | deque):
        return [encoded(each) for each in value]
    return value


def decoded(value: Any) -> Any:
    """What `encoded` made of it."""
    if isinstance(value, list):
        return [decoded(each) for each in value]
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return np.frombuffer(base64.b64decode(value["array"])).reshape(value["shape"]).copy()
    if "kind" in value:
        return _KINDS[value["kind"]](**{name: decoded(each) for name, each in value["of"].items()})
    if "tuple" in value:
        return tuple(decoded(each) for each in value["tuple"])
    return {name: decoded(each) for name, each in value["map"].items()}


def saved(
    path: Path, asked: Mapping[str, Any], watcher: Watcher, gatherer: Gatherer, more: Mapping[str, Any]
) -> None:
    """Write the state, whole or not at all.

    Parameters
    ----------
    path : of the file
    asked : what the watch was asked for; a restart has to ask for the same
    watcher, gatherer : as they are
    more : what else a restart needs
    """
    shadow, test = watcher.shadow, watcher.test
    facts: dict[str, Any] = {
        "asked": dict(asked),
        "gatherer": gatherer.state(),
        "watcher": encoded({name: getattr(watcher, name) for name in watcher.KEPT}),
        "shadow": None if shadow is None else encoded([getattr(shadow, name) for name in SHADOW_KEPT]),
        "snapshots": [
            (at, encoded([getattr(each, name) for name in SHADOW_KEPT])) for at, each in watcher.snapshots
        ],
        "test": None
        if test is None
        else encoded([test.sums.lean, test.sums.weight, test.level, test.settled]),
        "law": None if watcher.law is None else watcher.law.state(),
        **more,
    }
    with fresh_file(path) as scratch:
        scratch.write_bytes(stamped(facts))


def restored(path: Path, asked: Mapping[str, Any], watcher: Watcher, gatherer: Gatherer) -> bool:
    """Let a watcher go on from a state; False if there is none.

    Raises
    ------
    InputError
        The file is damaged, of another version, or the state of a watch that was asked for something else.
    """
    if not path.is_file():
        return False
    facts = _facts(path)
    with _of_this_version(path):
        before = dict(facts["asked"])
    if before != dict(asked):
        differ = ", ".join(n for n in asked if before.get(n) != asked[n])
        raise InputError(
            f"{path}: holds the state of a watch with another {differ}; choose another {argument('out')}, "
            "or remove the file to learn anew"
        )
    with _of_this_version(path):
        _take_up(facts, watcher, gatherer)
    return True


def beside(path: Path) -> Beside | None:
    """What a watch kept beside filter and test; None if there is no state; InputError as by `restored`."""
    if not path.is_file():
        return None
    facts = _facts(path)
    with _of_this_version(path):
        kept = Beside(**{name: facts[name] for name in Beside._fields})
        place = None if kept.place is None else FilePlace(*kept.place)
        counts = kept.rows, kept.doubtful, *(place or ())
        right = all(type(each["alarm"]) is bool and type(each["told"]) is str for each in kept.events)
        if type(kept.events) is not list or not right or any(type(each) is not int for each in counts):
            raise TypeError
        return kept._replace(place=place)


def _facts(path: Path) -> dict[str, Any]:
    facts = unstamped(path.read_bytes())
    if facts is None:
        raise InputError(f"{path}: is damaged; {_remedy()}")
    return facts


@contextmanager
def _of_this_version(path: Path) -> Iterator[None]:
    """Say so where a state has other fields or shapes, of which all kinds of errors come."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError):
        # The checksum says that it is as it was written, so by a version that kept something else.
        raise InputError(f"{path}: holds the state of another version of warmlink; {_remedy()}") from None


def _remedy() -> str:
    return f"remove it to learn anew, or choose another {argument('out')}"


def _take_up(facts: Mapping[str, Any], watcher: Watcher, gatherer: Gatherer) -> None:
    """Go on from a state."""
    gatherer.restore(facts["gatherer"])
    for name, value in decoded(facts["watcher"]).items():
        kept = getattr(watcher, name)
        setattr(watcher, name, deque(value, kept.maxlen) if isinstance(kept, deque) else value)
    if watcher.law is not None:
        watcher.law.restore(facts["law"])
    if watcher.learnt is not None and watcher.limits is not None:
        watcher.restart(watcher.learnt, watcher.limits)
        assert watcher.test is not None
        watcher.shadow = _shadow(watcher, facts["shadow"])
        watcher.snapshots = deque((at, _shadow(watcher, each)) for at, each in facts["snapshots"])
        test: Sequential = watcher.test
        test.sums.lean, test.sums.weight, test.level, test.settled = decoded(facts["test"])
        if watcher.recent:
            twin_of(watcher.shadow).step(watcher.recent[-1])


def _shadow(watcher: Watcher, arrays: Any) -> Shadow:
    assert watcher.learnt is not None
    learnt = watcher.learnt
    made = Shadow(watcher.machine, learnt.noise, learnt.values, learnt.offsets, learnt.weights)
    for name, value in zip(SHADOW_KEPT, decoded(arrays), strict=True):
        setattr(made, name, value)
    return made
