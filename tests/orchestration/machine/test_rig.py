"""What the wires of the shipped systems say of inputs, columns and sensors."""

from dataclasses import replace

from warmlink.fmus.component import Component, Input
from warmlink.orchestration.machine.rig import OFFSET, rig


def test_the_plant_of_the_cell_is_its_continuous_components() -> None:
    cell = rig("WarmupCell", 20)
    assert list(cell.components) == ["motor", "link"]
    assert sum(name.startswith("link.temperature[") for name in cell.component.x.names) == 20
    assert "motor.link_base_temperature" not in cell.externals
    assert "motor.speed" in cell.externals


def test_one_signal_feeds_what_the_duty_cycle_feeds() -> None:
    cell = rig("WarmupCell")
    assert set(cell.fed_with("link.ambient_temperature")) == {
        "motor.ambient_temperature",
        "link.ambient_temperature",
        "link.tip_sink_temperature",
    }
    assert set(cell.fed_with("motor.speed")) == {"motor.speed", "link.speed"}
    assert cell.fed_with("motor.neighbour_temperature") == ("motor.neighbour_temperature",)
    assert "link.tip_sink_temperature" in rig("BenchRod").fed_with("link.ambient_temperature")


def test_columns_of_a_bare_file_follow_from_the_wires() -> None:
    assert rig("WarmupCell").columns == {
        "speed": "motor.speed",
        "torque": "motor.torque",
        "pad_temperature": "motor.pad_temperature",
        "ambient_temperature": "motor.ambient_temperature",
        "shaft_temperature": "motor.shaft_temperature",
        "winding_temperature": "motor.winding_temperature",
        "base_temperature": "link.base_temperature",
        "middle_temperature": "link.sensor_temperature[2]",
        "tip_temperature": "link.tip_temperature",
        "elongation": "link.elongation",
    }
    assert rig("BenchRod").columns == rig("BenchMotor").columns == {}


def test_sensors_read_what_is_wired_to_them() -> None:
    cell, rod, motor = (rig(name).readings for name in ("WarmupCell", "BenchRod", "BenchMotor"))
    assert cell["motor.winding_temperature"] == "sensors[2]"
    assert cell["link.tip_temperature"] == cell["link.sensor_temperature[3]"] == "sensors[5]"
    assert cell["link.sensor_temperature[6]"] == "sensors[8]"
    assert cell["link.elongation"] == rod["link.elongation"] == "camera"
    assert rod["link.tip_temperature"] == rod["link.sensor_temperature[3]"] == "sensors[3]"
    assert motor == {"motor.shaft_temperature": "sensors[1]", "motor.winding_temperature": "sensors[2]"}


def test_every_run_should_have_what_drives_its_components() -> None:
    demands = (
        ("motor.speed",),
        ("motor.torque", "motor.current"),
        ("motor.pad_temperature", "motor.pad_power"),
        ("motor.ambient_temperature",),
    )
    assert rig("WarmupCell").required_inputs == rig("BenchMotor").required_inputs == demands
    assert rig("BenchRod").required_inputs == (("heater.on",), ("link.ambient_temperature",))


def test_a_vector_of_temperatures_is_no_place_on_a_link() -> None:
    cell = rig("WarmupCell")
    assert cell.on_link("link.sensor_temperature[2]") == ("link", 2)
    assert cell.on_link("link.tip_temperature") == ("link", 3)
    assert cell.on_link("link.sensor_temperature") is None


def test_a_room_is_known_by_the_name_of_an_input_not_of_its_part() -> None:
    inputs = tuple(Input(name, "K", "a", start=293.15) for name in ("coolant", "ambient_temperature"))
    box = Component("Box", "a box", inputs=inputs, observe=lambda x, u, p, time: {})
    cell = rig("WarmupCell")
    machine = replace(cell.machine, parts={**cell.machine.parts, "ambient_box": "Box"})
    found = replace(cell, machine=machine, foreign={"ambient_box": box}).wandering["room"]
    assert [each for each in found if "box" in each] == [f"{OFFSET}:ambient_box.ambient_temperature"]
