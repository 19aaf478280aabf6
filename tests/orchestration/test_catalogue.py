import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import components, controller, controllers, plants


def test_every_folder_that_declares_a_component_is_found() -> None:
    assert {"thermal_link", "motor_heat_source", "duty_cycle", "heater"} <= set(plants())
    assert {"none", "analytic", "lag"} <= set(controllers())
    assert "packaging" not in plants()


def test_controllers_are_interchangeable() -> None:
    interfaces = {
        tuple((s.name, s.variable.unit) for s in law.scalars() if s.name not in law.p.index)
        for law in controllers().values()
    }
    assert len(interfaces) == 1


def test_names_are_unique_across_plants_and_controllers() -> None:
    assert len(components()) == len(plants()) + len(controllers())


def test_an_unknown_controller_names_those_there_are() -> None:
    with pytest.raises(InputError, match="lag"):
        controller("magic")
