import re
from pathlib import Path

import pytest

from warmlink.fmus.component import Component
from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.errors import InputError
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue, read_cause
from warmlink.orchestration.diagnosis.model.instruments import CLOCK, DRIFT
from warmlink.orchestration.machine.rig import OFFSET, PLACE, SCALE, rig

CAUSES = Path(__file__).parents[4] / "orchestration" / "diagnosis" / "causes"

PROMISED = (
    "radiation",
    "still_air_convection",
    "forced_convection",
    "mixed_convection",
    "conductivity",
    "conductivity_temperature_dependence",
    "heat_capacity",
    "hub_heat_capacity",
    "tip_heat_capacity",
    "tip_heat_loss",
    "expansion_coefficient",
    "elongation_scale",
    "joint_resistance",
    "hub_heat_loss",
    "copper_loss",
    "friction_temperature_dependence",
    "friction_level",
    "standby_heat",
    "neighbour_heat",
    "ambient_offset",
    "ambient_drift",
    "radiant_heating",
    "sensor_lag",
    "sensor_offset",
    "sensor_stem_conduction",
    "camera_drift",
    "clock_offset",
    "communication_step",
    "clock_drift",
    "input_scale",
    "input_offset",
    "sensor_position",
    "link_length",
    "joint_temperature_dependence",
    "link_air_offset",
    "crosstalk",
    "joint_conductance",
    "iron_loss",
    "free_convection",
    "housing_heat_loss",
    "coulomb_friction",
    "backlash_heat",
    "viscous_friction",
    "lubricant_thinning",
    "winding_heat_path",
    "winding_heat_capacity",
    "shaft_heat_capacity",
    "start_temperature",
)


def test_the_example_of_the_readme_is_the_cause_of_that_name() -> None:
    readme = (CAUSES.parent / "README.md").read_text("utf-8")
    name, text = re.findall(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```", readme, re.DOTALL)[0]
    assert (CAUSES / name).read_text("utf-8") == text


def test_every_promised_cause_is_there() -> None:
    assert {cause.name for cause in catalogue()} >= set(PROMISED)


def has(component: Component, parameter: str) -> bool:
    return parameter in {p.name for p in component.parameters}


def test_every_cause_frees_a_parameter_of_an_fmu() -> None:
    cell = rig("WarmupCell")
    for cause in catalogue():
        for variable in cause.frees:
            if cause.kind == "plant":
                assert variable in cell.parameters, cause.name
            elif cause.kind == "record":
                assert variable in (CLOCK, DRIFT)
            elif cause.kind in ("input", "place"):
                assert variable in (SCALE, OFFSET, PLACE)
            elif cause.name == "crosstalk":
                assert cause.kind == "temperature sensor"
            elif cause.kind == "simulation":
                assert variable.startswith("simulation.")
            elif cause.kind == "camera":
                assert has(CAMERA, variable), cause.name
            elif cause.kind == "temperature sensor":
                assert has(SENSORS, variable), cause.name
            else:
                assert has(SENSORS, variable), cause.name
                assert has(CAMERA, variable), cause.name


def test_neutral_values_are_the_fmus_start_values() -> None:
    cell = rig("WarmupCell")
    for cause in catalogue():
        if cause.kind == "plant" and cause.neutral is not None and not cause.added:
            assert {cell.variables[v].start for v in cause.frees} == {cause.neutral}, cause.name


def test_bounds_lie_within_the_fmus() -> None:
    cell = rig("WarmupCell")
    for cause in catalogue():
        for variable in cause.frees if cause.kind == "plant" and not cause.added else ():
            scalar = cell.variables[variable]
            factor = scalar.start if cause.relative else 1.0
            assert factor is not None
            assert scalar.lower is None or cause.lower * factor >= scalar.lower, cause.name
            top = scalar.variable.maximum
            assert top is None or cause.upper * factor <= top, cause.name


def test_a_file_that_is_not_a_cause_is_refused_with_its_entry(tmp_path: Path) -> None:
    path = tmp_path / "leak.toml"
    entries = 'sentence = "S"\nlooks_like = "L"\ncheck = "C"\nlower = 0.0\nupper = 1.0\n'
    path.write_text(entries + 'frees = ["link.hub_conductance"]\n', "utf-8")
    assert read_cause(path).frees == ("link.hub_conductance",)
    path.write_text(entries + 'free = ["link.hub_conductance"]\n', "utf-8")
    with pytest.raises(InputError, match=r"leak\.toml: free is not known; did you mean frees\?"):
        read_cause(path)
