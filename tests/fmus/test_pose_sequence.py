"""The sequence of poses: each held for its time, then again."""

import numpy as np
import pytest

from warmlink.fmus.component.instance import Instance
from warmlink.fmus.pose_sequence.component import COMPONENT


def sequence(repeat: bool = True) -> Instance:
    instance = Instance(COMPONENT, "poses")
    for pose, (duration, first, last) in enumerate([(2.0, 0.1, -1.0), (3.0, 0.5, 2.0), (5.0, -0.2, 0.5)], 1):
        instance.set({f"duration[{pose}]": duration, f"joint_1[{pose}]": first, f"joint_6[{pose}]": last})
    instance.set({"repeat": float(repeat)})
    instance.initialize()
    return instance


def angles(instance: Instance, times: np.ndarray, step: float) -> np.ndarray:
    found = []
    for _ in times:
        found.append((instance.get("angle[1]"), instance.get("angle[6]")))
        instance.step(instance.time, step)
    return np.array(found)


def test_each_pose_is_held_for_its_time_and_all_begin_again() -> None:
    found = angles(sequence(), np.arange(20), 1.0)
    expected = [(0.1, -1.0)] * 2 + [(0.5, 2.0)] * 3 + [(-0.2, 0.5)] * 5
    assert found == pytest.approx(np.array(expected * 2))


def test_the_mean_over_a_sequence_is_that_of_its_poses() -> None:
    found = angles(sequence(), np.arange(100), 0.1)
    assert found[:, 0].mean() == pytest.approx((2 * 0.1 + 3 * 0.5 - 5 * 0.2) / 10)


def test_without_repeat_the_last_pose_holds() -> None:
    found = angles(sequence(repeat=False), np.arange(15), 1.0)
    assert np.all(found[10:] == (-0.2, 0.5))
