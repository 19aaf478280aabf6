"""What knows the equations of warmlink's components also knows those of a reduced link, from its FMU."""

from pathlib import Path

import numpy as np
import pytest

from tests.fmus.reduced_bar import LENGTH, bar_link, bar_model
from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.plant import cell_plant, plant_model
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging.native.fmu import native_fmu_files
from warmlink.fmus.reduced_link.equations import STORED, stored
from warmlink.orchestration.catalogue import reduced_link_in
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.studies.design import design
from warmlink.orchestration.system.replacement import Replacements

ORDER = 13


@pytest.fixture(scope="module")
def replaced(tmp_path_factory: pytest.TempPathFactory) -> Replacements:
    fmu = tmp_path_factory.mktemp("fmu") / "BarLink.fmu"
    entry = Entry(bar_link(ORDER), "warmlink.fmus.reduced_link.component")
    files = native_fmu_files(entry, "2.0", [])  # nothing here runs it
    write_archive(fmu, {**files, STORED: stored(bar_model(ORDER))})
    return Replacements({"link": fmu}, {})


def test_an_fmu_holds_the_model_of_its_link(replaced: Replacements, tmp_path: Path) -> None:
    read, made = reduced_link_in(replaced.fmus["link"]), bar_link(ORDER)
    assert read is not None
    p, u = made.start_values({"heat_flow": 5.0, "hub_heat_capacity": 10.0})
    x = np.linspace(1.0, 2.0, made.x.size)
    assert read.rates_of(x, u, read.settled(p), 0.0) == pytest.approx(
        made.rates_of(x, u, made.settled(p), 0.0)
    )
    write_archive(tmp_path / "Other.fmu", {"modelDescription.xml": b"", STORED: b"{}"})
    assert reduced_link_in(tmp_path / "Other.fmu") is None


def test_an_observer_is_designed_for_it_as_for_the_slender_link_that_it_is(replaced: Replacements) -> None:
    found = design("WarmupCell", replaced=replaced)
    slender = cell_plant(link={"base_position": 0.0, "tip_position": LENGTH})
    expected = design_controller(plant=slender).reduced
    assert found.reduced is not None
    assert found.reduced.rate[:3] == pytest.approx(expected.rate[:3], rel=0.01)
    assert found.reduced.elongation_per_kelvin == pytest.approx(expected.elongation_per_kelvin)
    assert found.reduced.link_loss == pytest.approx(expected.link_loss, rel=1e-4)
    assert found.reduced.error.elongation_step < 1e-7
    assert "sensor_position" not in found.summary(), "a reduced link has none"
    uniform = bar_model(ORDER).initial.sum(axis=1)
    assert plant_model(found.plant).uniform == pytest.approx([1.0, 1.0, *uniform], abs=1e-6)


def test_a_diagnosis_has_its_equations_and_no_loop_of_fmus(replaced: Replacements) -> None:
    rig = rig_of("WarmupCell", replaced=replaced)
    assert not rig.in_loop
    assert rig.called("link") == ["link"]
    assert f"link.pattern_temperature[{ORDER}]" in rig.component.x.names
    assert rig.readings["link.tip_temperature"] == "sensors[5]"
