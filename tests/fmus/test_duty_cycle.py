"""DutyCycle: the segment in force at any time, and nothing remembered."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.duty_cycle.component import COMPONENT, SEGMENTS
from warmlink.fmus.errors import InputError

COLD = 295.15


def duty(durations: list[float], repeat: bool = False) -> Instance:
    """Segment k runs at speed k, torque 10 k, and so on."""
    instance = Instance(COMPONENT)
    values: dict[str, float] = {"repeat": float(repeat)}
    for k in range(1, SEGMENTS + 1):
        values |= {
            f"duration[{k}]": durations[k - 1] if k <= len(durations) else 0.0,
            f"segment_speed[{k}]": k,
            f"segment_torque[{k}]": 10.0 * k,
            f"segment_ambient_temperature[{k}]": COLD + k,
            f"segment_pad_mode[{k}]": k % 3,
            f"segment_pad_temperature[{k}]": COLD + 2 * k,
            f"segment_pad_power[{k}]": 5.0 * k,
        }
    instance.set(values)
    instance.initialize()
    return instance


def segment_at(instance: Instance, time: float) -> int:
    p = np.array([instance.get(name) for name in COMPONENT.p.names])
    y = COMPONENT.y.read(COMPONENT.outputs_of(np.zeros(0), np.zeros(0), COMPONENT.settled(p), time))
    k = int(y.speed)
    assert list(y) == [k, 10.0 * k, COLD + k, k % 3, COLD + 2 * k, 5.0 * k]
    return k


def test_as_declared_it_is_full_duty() -> None:
    instance = Instance(COMPONENT)
    instance.initialize()
    assert instance.outputs().tolist() == [3.43, 2.5, COLD, 0, COLD, 0]


def test_a_segment_begins_exactly_where_the_former_ends() -> None:
    instance = duty([10.0, 20.0, 5.0])
    assert [segment_at(instance, t) for t in (0.0, 9.999, 10.0, 29.999, 30.0, 34.9, 35.0, 1e6)] == [
        1,
        1,
        2,
        2,
        3,
        3,
        3,
        3,
    ]


def test_unused_segments_are_left_out_wherever_they_are() -> None:
    instance = duty([0.0, 10.0, 0.0, 0.0, 20.0, 0.0])
    assert [segment_at(instance, t) for t in (0.0, 9.9, 10.0, 29.9, 30.0, 500.0)] == [2, 2, 5, 5, 5, 5]


def test_all_thirty_two_segments_serve() -> None:
    instance = duty([1.0] * SEGMENTS)
    assert [segment_at(instance, k + 0.5) for k in range(40)] == [min(k + 1, SEGMENTS) for k in range(40)]


def test_repeated_it_begins_again() -> None:
    instance = duty([10.0, 20.0], repeat=True)
    assert [segment_at(instance, t) for t in (0.0, 10.0, 29.9, 30.0, 40.0, 59.9, 60.0, 3e6, 3e6 + 10)] == [
        1,
        2,
        2,
        1,
        2,
        2,
        1,
        1,
        2,
    ]


@settings(max_examples=30, deadline=None)
@given(
    durations=st.lists(st.integers(1, 5000), min_size=1, max_size=SEGMENTS),
    step=st.sampled_from([0.1, 0.3, 1 / 3, 0.7]),
    repeat=st.booleans(),
)
def test_beginnings_survive_rounding(durations: list[int], step: float, repeat: bool) -> None:
    """Durations of whole steps; times are k steps, and also as a master gets them by adding steps up."""
    instance = duty([count * step for count in durations], repeat)
    begins = np.concatenate([[0], np.cumsum(durations)])
    rounds = 3 if repeat else 1
    for turn in range(rounds):
        for k, begin in enumerate(begins[:-1]):
            count = int(begin + turn * begins[-1])
            summed = math.fsum([step]) * count * (1 - 1e-12)
            assert segment_at(instance, count * step) == k + 1
            assert segment_at(instance, summed) == k + 1
            if count > 0:
                before = len(durations) if k == 0 else k
                assert segment_at(instance, (count - 0.5) * step) == before


def test_the_value_at_a_communication_point_is_that_of_the_step_from_there() -> None:
    instance = duty([10.0, 20.0])
    seen = []
    for k in range(12):
        seen.append(instance.get("speed"))
        instance.step(float(k), 1.0)
    assert seen == [1.0] * 10 + [2.0] * 2
    assert not instance.component.states


def test_a_duty_cycle_of_no_length_is_refused() -> None:
    instance = Instance(COMPONENT, "duty")
    instance.set({"duration[1]": 0.0})
    with pytest.raises(
        InputError, match=r"duty\.duration\[1\]: 0 s, and no other segment lasts longer; give"
    ):
        instance.initialize()
