"""What a watcher knows as one checksummed line of JSON, so that a restart goes on bit for bit."""

from __future__ import annotations

import base64
from collections import deque
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.files import fresh_file, stamped, unstamped
from warmlink.orchestration.watch.combining import Scatter
from warmlink.orchestration.watch.filter.noise import ShadowNoise
from warmlink.orchestration.watch.filter.shadow import Shadow
from warmlink.orchestration.watch.learning import SoundPart
from warmlink.orchestration.watch.sequential import Limits, Sequential
from warmlink.orchestration.watch.ticks import Gatherer, Tick
from warmlink.orchestration.watch.watcher import SHADOW_KEPT, Moment, Standing, Watcher, twin_of

_KINDS = {each.__name__: each for each in (Tick, ShadowNoise, Scatter, SoundPart, Limits, Standing, Moment)}


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


def restored(
    path: Path, asked: Mapping[str, Any], watcher: Watcher, gatherer: Gatherer
) -> dict[str, Any] | None:
    """Let a watcher go on from a state; None if there is none.

    Raises
    ------
    InputError
        The file is damaged, of another version, or the state of a watch that was asked for something else.
    """
    if not path.is_file():
        return None
    facts = unstamped(path.read_bytes())
    remedy = f"remove it to learn anew, or choose another {argument('out')}"
    if facts is None:
        raise InputError(f"{path}: is damaged; {remedy}")
    if facts["asked"] != dict(asked):
        differ = ", ".join(n for n in asked if facts["asked"].get(n) != asked[n])
        raise InputError(
            f"{path}: holds the state of a watch with another {differ}; choose another {argument('out')}, "
            "or remove the file to learn anew"
        )
    try:
        _take_up(facts, watcher, gatherer)
    except (LookupError, TypeError, ValueError, AttributeError):
        # The checksum says that it is as it was written, so by a version that kept something else.
        raise InputError(f"{path}: holds the state of another version of warmlink; {remedy}") from None
    return facts


def _take_up(facts: Mapping[str, Any], watcher: Watcher, gatherer: Gatherer) -> None:
    """Go on from a state; it raises all kinds of errors if that has other fields or shapes."""
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
