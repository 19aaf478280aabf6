"""What drives a system."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from warmlink.orchestration.system.model import Value

StartValues = Mapping[str, Mapping[str, Value]]
"""Start values in SI units by instance and variable."""


@dataclass(frozen=True)
class Drive:
    """What drives a system: a duty cycle, or a program of an arm.

    Attributes
    ----------
    name, title, reason : what it is called, in short and in a line, and why it is as it is
    stop_time : in s
    remarks : what was taken for granted where a file did not say it
    """

    name: str
    title: str
    reason: str
    stop_time: float
    remarks: tuple[str, ...] = field(default=(), kw_only=True)

    def until(self, stop_time: float) -> Self:
        """The same with another stop time in s."""
        return replace(self, stop_time=stop_time)

    def start_values(self) -> StartValues:
        """Start values of the instances that drive the others."""
        raise NotImplementedError
