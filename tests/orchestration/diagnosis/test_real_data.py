"""Real measurements, where the machine has them; they are not part of the project."""

import pytest

from tests.shared_data import given
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read


@pytest.mark.platform
def test_a_robot_joint_needs_nothing_added() -> None:
    found = diagnose_experiment(read([given("motor/motor.toml")]))
    assert found.verdict == "adequate"
    assert json_content(found)["gain"]["runs"]["fit"]["temperature_J3"]["rmse_before"] < 0.05


@pytest.mark.platform
@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_a_rod_is_ambiguous_and_some_member_predicts_the_held_out_run() -> None:
    found = diagnose_experiment(read([given("rod/rod.toml")]))
    assert found.verdict == "ambiguous"
    members = json_content(found)["gain"]["heldout"]["members"]
    errors = []
    for member in members.values():
        channels = member["runs"]["0609hs"].values()
        errors.append((sum(c["rmse_after"] ** 2 for c in channels) / len(channels)) ** 0.5)
    assert min(errors) < 0.7
    # From these two runs neither surface and orientation nor radiation and a larger h can be told apart.
    alike = {"radiation per surface", "radiation per orientation", "still_air_convection per surface"}
    assert all(any(title in name.split("+") for name in members) for title in alike)
    assert found.proposed is not None
    assert "surface" in found.proposed.why
    assert "orientation" in found.proposed.why


@pytest.mark.platform
@pytest.mark.parametrize(
    ("name", "cause"),
    [
        ("pad_uneven_rows", "joint_resistance"),
        ("pad_offset_uneven_rows", "sensor_offset:middle_temperature"),
        ("pad_friction", "friction_level"),
    ],
)
def test_a_stranger_s_run_with_the_pad_on_is_named(name: str, cause: str) -> None:
    found = diagnose_experiment(read([given(f"strangers/{name}.csv")]))
    assert found.verdict == "named"
    assert [item.title for item in found.causes] == [cause]
