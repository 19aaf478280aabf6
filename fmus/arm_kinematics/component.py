"""The arm's kinematics as a component."""

from math import pi

from warmlink.fmus.arm_kinematics import equations
from warmlink.fmus.component import Check, Component, Derived, Input, Output, Parameter, Record
from warmlink.fmus.component.arithmetic import Number, absolute
from warmlink.fmus.component.quantities import growth_input, growth_told, length_parameter

AXES = equations.AXES

_DIRECTION_TOLERANCE = 1e-6


def _angles(name: str, description: str, starts: tuple[float, ...]) -> Parameter:
    return Parameter(name, "rad", 0, description, size=AXES, starts=starts, display="deg", nominal=1)


def _lengths(name: str, description: str, starts: tuple[float, ...]) -> Parameter:
    return length_parameter(name, 0, description, size=AXES, starts=starts, nominal=0.3)


def _direction(coordinate: str, starts: tuple[float, ...]) -> Parameter:
    about = f"{coordinate} of the unit vector, in the link's own frame, along which the link grows"
    return Parameter(f"growth_{coordinate}", "1", 0, about, size=AXES, starts=starts, minimum=-1, maximum=1)


def _point(name: str, description: str) -> Output:
    return Output(name, "m", description, size=3, display="mm", nominal=0.5)


_MISSED = "true tool point minus the one computed with the {} dimensions: x, y, z"
_CORRECTION = "growth of each link that the robot's controller has put into its nominal dimensions"
_TWISTS = (pi / 2, 0, pi / 2, -pi / 2, pi / 2, 0)


def _one_long(axis: int) -> Check:
    def margin(p: Record) -> Number:
        square = p.growth_x[axis] ** 2 + p.growth_y[axis] ** 2 + p.growth_z[axis] ** 2
        return _DIRECTION_TOLERANCE - absolute(square - 1)

    return Check(
        margin,
        f"growth_x[{axis + 1}]: {{growth_x[{axis + 1}]}} with growth_y {{growth_y[{axis + 1}]}} and growth_z "
        f"{{growth_z[{axis + 1}]}} is no unit vector; give a direction of length 1",
    )


COMPONENT = Component(
    name="ArmKinematics",
    description="Tool point of a six-axis arm, its error by the links' growth, and the sensitivities",
    inputs=(
        Input("angle", "rad", "angle of each joint", size=AXES, display="deg", nominal=1),
        growth_input("elongation", "growth of each link", size=AXES),
        growth_input("correction", _CORRECTION, size=AXES),
    ),
    parameters=(
        _angles("joint_offset", "angle to add to the joint's", (0, pi / 2, pi / 2, 0, 0, 0)),
        _lengths("link_offset", "distance along the joint's axis", (0.3302, 0, 0, 0.3302, 0, 0.2262)),
        _lengths("link_length", "distance along the common normal", (0, 0.3048, 0, 0, 0, 0)),
        _angles("link_twist", "angle from one joint's axis to the next", _TWISTS),
        _direction("x", (0, 1, 0, 0, 0, 0)),
        _direction("y", (1, 0, 0, -1, 0, 0)),
        _direction("z", (0, 0, 1, 0, 1, 1)),
    ),
    derived=(Derived("twist_cosine", "1", size=AXES), Derived("twist_sine", "1", size=AXES)),
    outputs=(
        _point("position", "tool point of the grown arm: x, y, z"),
        _point("nominal_position", "tool point with nominal dimensions"),
        growth_told("error", _MISSED.format("adjusted"), size=3),
        growth_told("error_norm", "length of the error"),
        growth_told("uncompensated_error", _MISSED.format("nominal"), size=3),
        growth_told("uncompensated_error_norm", "length of that error"),
        *(
            Output(f"sensitivity_{k}", "1", f"{k} of the tool point by each elongation", size=AXES, nominal=1)
            for k in equations.COORDINATES
        ),
    ),
    derive=equations.derive,
    observe=equations.outputs,
    checks=tuple(_one_long(axis) for axis in range(AXES)),
)
