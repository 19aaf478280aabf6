"""Mock systems whose monolithic solution is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from warmlink.orchestration.master.assembly import Assembly
from warmlink.orchestration.system.model import Connection

from .mock import Inputs, MockSlave


def wire(text: str, factor: float = 1.0, offset: float = 0.0) -> Connection:
    """Read `a.y -> b.u`."""
    source, target = (end.strip().split(".") for end in text.split("->"))
    return Connection(*source, *target, factor, offset)


def counter(name: str, rate: float = 1.0, **options: Any) -> MockSlave:
    """x' = rate * u, y = x, exact for inputs of degree two in time."""

    def advance(x: float, u: Inputs, t: float, h: float) -> float:
        value, first, second = u.coefficients("u")
        return x + rate * h * (value + h * (first / 2 + h * second / 6))

    return MockSlave(
        name,
        inputs={"u": 1.0},
        outputs={"y": lambda x, u, t: x},
        state=0.0,
        advance=advance,
        **options,
    )


def gain(name: str, factor: float, **options: Any) -> MockSlave:
    """y = factor * u at once."""
    return MockSlave(
        name,
        inputs={"u": 0.0},
        outputs={"y": lambda x, u, t: factor * u["u"]},
        feedthrough={"y": ["u"]},
        **options,
    )


def interrupt_at(share: float) -> Callable[[int, int], None]:
    """Make a progress callback that presses Ctrl-C once, after a share of the run."""

    def progress(done: int, total: int) -> None:
        if share * total <= done < total:
            raise KeyboardInterrupt

    return progress


def assembly(slaves: list[MockSlave], *wires: Connection, **values: dict[str, Any]) -> Assembly:
    return Assembly(slaves, wires, values)
