from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.packaging.component import Component
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS
from warmlink.orchestration.diagnosis.causes.catalogue import catalogue
from warmlink.orchestration.diagnosis.data.rig import RIGS, rig
from warmlink.orchestration.diagnosis.model.instruments import CLOCK
from warmlink.orchestration.system.shipped import SHIPPED

PROMISED = (
    "radiation",
    "still_air_convection",
    "forced_convection",
    "conductivity",
    "conductivity_temperature_dependence",
    "heat_capacity",
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
)


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
                assert variable == CLOCK
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
        if cause.kind == "plant" and cause.neutral is not None:
            assert {cell.variables[v].start for v in cause.frees} == {cause.neutral}, cause.name


def test_bounds_lie_within_the_fmus() -> None:
    cell = rig("WarmupCell")
    for cause in catalogue():
        for variable in cause.frees if cause.kind == "plant" else ():
            scalar = cell.variables[variable]
            factor = scalar.start if cause.relative else 1.0
            assert factor is not None
            assert scalar.lower is None or cause.lower * factor >= scalar.lower, cause.name
            top = scalar.variable.maximum
            assert top is None or cause.upper * factor <= top, cause.name


def test_rigs_are_wired_as_the_shipped_systems() -> None:
    for name in RIGS:
        here, shipped = rig(name), SHIPPED[name]
        wires = {target: source for source, target in shipped.wires}
        for target, source in here.connections.items():
            assert wires[target] == source
        for output, reading in here.readings.items():
            if reading.startswith("sensors") and reading.replace("[", ".temperature[") in wires:
                source = wires[reading.replace("[", ".temperature[")]
                same = {source, output} <= {"link.base_temperature", "link.sensor_temperature[1]"}
                same |= {source, output} <= {"link.tip_temperature", "link.sensor_temperature[3]"}
                assert source == output or same
