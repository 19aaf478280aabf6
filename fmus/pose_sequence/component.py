"""The sequence of poses as a component."""

from __future__ import annotations

from warmlink.fmus.component import Check, Component, Derived, Output, Parameter
from warmlink.fmus.component.arithmetic import total
from warmlink.fmus.pose_sequence import equations

POSES, AXES = equations.POSES, equations.AXES

COMPONENT = Component(
    name="PoseSequence",
    description="Up to 32 poses of a six-axis arm, each held for a time; all begin again, or the last holds",
    parameters=(
        Parameter(
            "duration",
            "s",
            0,
            "how long each pose is held; 0: not used",
            size=POSES,
            starts=(60.0, *(0.0,) * (POSES - 1)),
            minimum=0,
            maximum=equations.LONGEST,
            nominal=60,
        ),
        *(
            Parameter(
                f"joint_{axis}",
                "rad",
                0,
                f"angle of joint {axis} in each pose",
                size=POSES,
                display="deg",
                nominal=1,
            )
            for axis in range(1, AXES + 1)
        ),
        Parameter("repeat", "1", 1, "whether the poses begin again after the last", type="Boolean"),
    ),
    derived=(
        Derived("segment_begin", "s", size=POSES),
        Derived("length", "s"),
    ),
    outputs=(Output("angle", "rad", "angle of each joint", size=AXES, display="deg", nominal=1),),
    derive=equations.derive,
    observe=equations.outputs,
    checks=(
        Check(
            lambda p: total(p.duration) - 1e-3,
            "duration[1]: {duration[1]} s, and no other pose is held longer; "
            "give at least one pose 0.001 s or more",
        ),
    ),
)
