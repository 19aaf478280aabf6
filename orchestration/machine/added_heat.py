"""What a rig asks of a heat path that a cause may add to its machine."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore


class HeatPath(Protocol):
    """A conductance or a source of heat that a cause may add: see `diagnosis/causes/declared.py`."""

    @property
    def parameter(self) -> str:
        """Name of its parameter that is 0 until the cause acts; empty if it always carries heat."""

    @property
    def sources(self) -> Mapping[str, str]:
        """The output behind each of its inputs."""

    @property
    def totals(self) -> Mapping[str, str]:
        """The heat flow behind each of its ends that it changes."""

    def fmu(self, store: FmuStore) -> Path:
        """Its FMU, from a store, built where it is missing."""


Paths = Mapping[str, HeatPath]
"""Heat paths by the name of their cause, which is that of their instance."""
