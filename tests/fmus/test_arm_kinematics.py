"""The arm's kinematics: known poses, and errors as differences of tool points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warmlink.fmus.arm_kinematics.component import AXES, COMPONENT
from warmlink.fmus.component.instance import Instance

COORDINATES = ("x", "y", "z")
UPRIGHT = 0.3302 + 0.3048 + 0.3302 + 0.2262
LENGTHS = [0.3302, 0.3048, 0.1500, 0.1802, 0.0762, 0.1500]


def arm(angle: np.ndarray, elongation: np.ndarray | None = None, **parameters: float) -> Instance:
    instance = Instance(COMPONENT, "arm")
    instance.set({name.replace("__", "[") + "]": value for name, value in parameters.items()})
    set_vector(instance, "angle", angle)
    set_vector(instance, "elongation", np.zeros(AXES) if elongation is None else elongation)
    instance.initialize()
    return instance


def set_vector(instance: Instance, name: str, values: np.ndarray) -> None:
    instance.set({f"{name}[{i + 1}]": float(value) for i, value in enumerate(values)})


def vector(instance: Instance, name: str, size: int = 3) -> np.ndarray:
    return np.array([instance.get(f"{name}[{i + 1}]") for i in range(size)])


def sensitivity(instance: Instance) -> np.ndarray:
    """Shape (3, axes)."""
    return np.array([vector(instance, f"sensitivity_{k}", AXES) for k in COORDINATES])


def transform(theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    """Denavit-Hartenberg's matrix as it stands in textbooks."""
    ct, st_, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [
            [ct, -st_ * ca, st_ * sa, a * ct],
            [st_, ct * ca, -ct * sa, a * st_],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    )


def tool_point(angle: np.ndarray, grown: np.ndarray) -> np.ndarray:
    """Product of matrices, each link's dimension lengthened where it stands in the table."""
    half = np.pi / 2
    d1, a2, d4, d6 = (
        0.3302 + grown[0],
        0.3048 + grown[1],
        0.3302 + grown[2] + grown[3],
        0.2262 + sum(grown[4:]),
    )
    rows = [
        (angle[0], d1, 0, half),
        (angle[1] + half, 0, a2, 0),
        (angle[2] + half, 0, 0, half),
        (angle[3], d4, 0, -half),
        (angle[4], 0, 0, half),
        (angle[5], d6, 0, 0),
    ]
    return np.linalg.multi_dot([transform(*row) for row in rows])[:3, 3]


ANGLES = st.lists(st.floats(-3.1, 3.1), min_size=AXES, max_size=AXES).map(np.array)
GROWTHS = st.lists(st.floats(-2e-4, 2e-4), min_size=AXES, max_size=AXES).map(np.array)


def test_upright_every_link_lifts_the_tool_point() -> None:
    upright = arm(np.zeros(AXES))
    assert vector(upright, "position") == pytest.approx([0, 0, UPRIGHT], abs=1e-15)
    assert sensitivity(upright) == pytest.approx(np.outer([0, 0, 1], np.ones(AXES)), abs=1e-15)


def test_reaching_out_the_column_lifts_and_the_arm_pushes() -> None:
    out = arm(np.array([0, -np.pi / 2, 0, 0, 0, 0]))
    assert vector(out, "position") == pytest.approx([UPRIGHT - 0.3302, 0, 0.3302], abs=1e-15)
    assert sensitivity(out)[:, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    assert sensitivity(out)[:, 1:] == pytest.approx(np.outer([1, 0, 0], np.ones(AXES - 1)), abs=1e-15)


def test_the_dimensions_are_those_of_the_links_in_the_shipped_arm() -> None:
    assert sum(LENGTHS) == pytest.approx(UPRIGHT)


@given(ANGLES, GROWTHS)
@settings(max_examples=40, deadline=None)
def test_the_tool_point_is_the_product_of_the_matrices(angle: np.ndarray, grown: np.ndarray) -> None:
    found = arm(angle, grown)
    assert vector(found, "nominal_position") == pytest.approx(tool_point(angle, np.zeros(AXES)), abs=1e-14)
    assert vector(found, "position") == pytest.approx(tool_point(angle, grown), abs=1e-14)


@given(ANGLES, GROWTHS, GROWTHS)
@settings(max_examples=40, deadline=None)
def test_the_error_is_the_difference_of_two_tool_points(
    angle: np.ndarray, grown: np.ndarray, corrected: np.ndarray
) -> None:
    found = arm(angle, grown)
    set_vector(found, "correction", corrected)
    expected = tool_point(angle, grown) - tool_point(angle, corrected)
    assert np.abs(vector(found, "error") - expected).max() < 1e-13
    assert found.get("error_norm") == pytest.approx(np.linalg.norm(expected), abs=1e-13)
    plain = tool_point(angle, grown) - tool_point(angle, np.zeros(AXES))
    assert np.abs(vector(found, "uncompensated_error") - plain).max() < 1e-13
    assert found.get("uncompensated_error_norm") == pytest.approx(np.linalg.norm(plain), abs=1e-13)


@given(ANGLES)
@settings(max_examples=20, deadline=None)
def test_sensitivities_are_unit_vectors_and_finite_differences(angle: np.ndarray) -> None:
    found = sensitivity(arm(angle))
    assert np.linalg.norm(found, axis=0) == pytest.approx(np.ones(AXES), abs=1e-14)
    step = 1e-3
    for i in range(AXES):
        grown = step * np.eye(AXES)[i]
        slope = (tool_point(angle, grown) - tool_point(angle, -grown)) / (2 * step)
        assert found[:, i] == pytest.approx(slope, abs=1e-12)
    assert found[:, 2] == pytest.approx(found[:, 3], abs=1e-14)
    assert found[:, 4] == pytest.approx(found[:, 5], abs=1e-14)


def test_the_sensitivities_are_the_component_s_own_derivatives() -> None:
    """By a complex step through the outputs: what the native FMU's directional derivatives are."""
    rng = np.random.default_rng(3)
    found = arm(rng.normal(size=AXES), 1e-4 * rng.normal(size=AXES))
    c = found.component
    settled = np.asarray(c.settled(np.array([found.get(name) for name in c.p.names])))
    u = np.array([found.get(name) for name in c.u.names], dtype=complex)
    for i in range(AXES):
        stepped = u.copy()
        stepped[c.u.index[f"elongation[{i + 1}]"]] += 1e-30j
        y = np.imag(c.outputs_of(np.zeros(0), stepped, settled, 0.0)) / 1e-30
        of = [c.y.index[f"position[{k}]"] for k in (1, 2, 3)]
        assert y[of] == pytest.approx(sensitivity(found)[:, i], abs=1e-14)
        assert np.all(np.isfinite(y))


def test_a_tool_that_is_where_it_should_be_has_no_error_and_finite_derivatives() -> None:
    found = arm(np.full(AXES, 0.3), np.full(AXES, 1e-5))
    set_vector(found, "correction", np.full(AXES, 1e-5))
    assert found.get("error_norm") == 0


def test_a_direction_that_is_not_of_length_one_is_refused() -> None:
    from warmlink.fmus.component import limits

    values = [s.start for s in COMPONENT.scalars()][: COMPONENT.p.size]
    assert not list(limits.problems(COMPONENT, "arm", values))
    values[COMPONENT.p.index["growth_x[2]"]] = 0.5
    (sentence,) = limits.problems(COMPONENT, "arm", values)
    assert sentence.startswith("arm.growth_x[2]: 0.5 with growth_y 0")
    assert "give a direction of length 1" in sentence
