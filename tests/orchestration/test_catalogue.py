import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import components, controller, controllers


def test_every_folder_that_declares_a_component_is_found() -> None:
    assert {"ThermalLink", "MotorHeatSource", "DutyCycle", "Heater"} <= set(components())
    assert {"none", "analytic", "lag"} <= set(controllers())
    assert "ThermalLink" not in {law.name for law in controllers().values()}


def test_controllers_are_interchangeable() -> None:
    """But for what an observer gives its host to keep, which no other component takes."""
    interfaces = {
        tuple(
            (s.name, s.variable.unit)
            for s in law.scalars()
            if s.name not in law.p.index and s.variable.name != "retained"
        )
        for law in controllers().values()
    }
    assert len(interfaces) == 1


def test_an_unknown_controller_names_those_there_are() -> None:
    with pytest.raises(InputError, match="lag"):
        controller("magic")
