"""FMUs that are built beside each other are the same to the last byte as those that are built alone."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from warmlink.fmus import calls
from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component.dependencies import dependencies
from warmlink.fmus.packaging.native.compile import Compiler
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.packaging.native.rollout_code import compiled
from warmlink.orchestration.catalogue import controller
from warmlink.orchestration.machine.shipped import machine_named

CHOSEN = ("DriftCamera", "Heater", "LagCompensator", "TemperatureSensors", "ThermalLink")


def files(entry: Entry) -> dict[str, bytes]:
    return native_fmu_files(entry, "2.0", ())


def test_what_is_built_beside_others_is_what_is_built_alone() -> None:
    entries = [entry for entry in catalogue() if entry.component.name in CHOSEN]
    alone = [files(entry) for entry in entries]
    dependencies.cache_clear()
    calls._whole.cache_clear()
    with ThreadPoolExecutor(2) as pool:
        beside = list(pool.map(files, entries))
    for one, other in zip(alone, beside, strict=True):
        assert [name for name in one if one[name] != other[name]] == []


def test_what_is_built_after_a_rollout_is_what_is_built_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions that a rollout was the first to write out were kept as it simplifies them."""
    (entry,) = (entry for entry in catalogue() if entry.component.name == "TemperatureSensors")
    calls._whole.cache_clear()
    alone = files(entry)
    calls._whole.cache_clear()
    monkeypatch.setattr(Compiler, "library", lambda *given: b"")
    compiled(machine_named("WarmupCell").joined(controller("lag")), ["link.elongation"])
    assert files(entry) == alone
