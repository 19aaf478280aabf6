"""FMUs that are built beside each other are the same to the last byte as those that are built alone."""

from concurrent.futures import ThreadPoolExecutor

from warmlink.fmus import calls
from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component.dependencies import dependencies
from warmlink.fmus.packaging.native.fmu import native_fmu_files

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
