"""The sequence of poses as a component."""

from typing import Any

from warmlink.fmus.component import Component, Output, Parameter
from warmlink.fmus.duty_cycle.component import TIMES, durations, lasting
from warmlink.fmus.pose_sequence import equations

POSES, AXES = equations.POSES, equations.AXES

_ANGLES: dict[str, Any] = {"size": POSES, "display": "deg", "nominal": 1}

COMPONENT = Component(
    name="PoseSequence",
    description="Up to 32 poses of a six-axis arm, each held for a time; all begin again, or the last holds",
    parameters=(
        durations("how long each pose is held", 60.0, 60),
        *(
            Parameter(f"joint_{i}", "rad", 0, f"angle of joint {i} in each pose", **_ANGLES)
            for i in range(1, AXES + 1)
        ),
        Parameter("repeat", "1", 1, "whether the poses begin again after the last", type="Boolean"),
    ),
    derived=TIMES,
    outputs=(Output("angle", "rad", "angle of each joint", size=AXES, display="deg", nominal=1),),
    derive=equations.derive,
    observe=equations.outputs,
    checks=(lasting("pose", "is held"),),
)
