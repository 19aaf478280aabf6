"""A column may hold a weighted sum of outputs, and what is none is refused."""

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.machine.rig import rig
from warmlink.orchestration.machine.sums import with_sums

GRADIENT = "link.base_temperature - link.tip_temperature"
MEAN = "0.5 * link.base_temperature + 0.5 * link.tip_temperature"


def test_a_sum_is_a_variable_with_its_weights_and_unit() -> None:
    cell = rig("WarmupCell")
    found = with_sums(cell, [GRADIENT, "link.tip_temperature", GRADIENT], "[channels]")
    assert [*found.sums] == [GRADIENT]
    assert found.sums[GRADIENT].weights == {"link.base_temperature": 1.0, "link.tip_temperature": -1.0}
    assert found.sums[GRADIENT].scalar.variable.unit == "K"
    assert with_sums(cell, ["link.tip_temperature"], "[channels]") is cell


def test_a_mean_of_temperatures_is_read_in_celsius_and_a_difference_is_not() -> None:
    found = with_sums(rig("WarmupCell"), [GRADIENT, MEAN], "[channels]").sums
    assert found[MEAN].scalar.variable.display == "degC"
    assert found[GRADIENT].scalar.variable.display is None


def test_what_is_counted_nothing_is_left_out() -> None:
    text = "link.base_temperature - 0 * link.tip_temperature"
    (found,) = with_sums(rig("WarmupCell"), [text], "[channels]").sums.values()
    assert found.weights == {"link.base_temperature": 1.0}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("2 + 3", "names no variable of WarmupCell"),
        ("link.elongation + motor.speed", "has motor.speed"),
        ("link.elongation + link.tip_temperature", "add outputs of one unit"),
        ("2 * link.base_temperature - 0.5 * link.tip_temperature", "add up to 1.5"),
        ("link.base_temperature * link.tip_temperature", "link.base_temperature"),
        ("link.length_of_day - link.tip_temperature", "length_of_day"),
    ],
)
def test_what_is_no_sum_of_outputs_is_refused_with_its_place(text: str, told: str) -> None:
    with pytest.raises(InputError) as fault:
        with_sums(rig("WarmupCell"), [text], "[channels]")
    assert str(fault.value).startswith(f"[channels].{text}")
    assert told in str(fault.value)
