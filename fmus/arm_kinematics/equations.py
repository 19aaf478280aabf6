"""The tool point of an arm by the Denavit-Hartenberg convention, and how far its links' growth moves it.

Frame i lies at the far end of link i. From the frame before it, turn about z by angle plus offset, move
along that z by `link_offset`, along the new x by `link_length`, and turn about it by `link_twist` (J.
Denavit and R. S. Hartenberg, "A kinematic notation for lower-pair mechanisms based on matrices", J. Appl.
Mech. 22 (1955) 215-221, in the form of R. P. Paul, *Robot Manipulators*, MIT Press 1981). Growth of link i
moves everything beyond it along a direction that is fixed in frame i, and turns nothing.
"""

from typing import NamedTuple

from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import Number, cos, maximum, sin, sqrt, stack, total, where

AXES = 6

COORDINATES = ("x", "y", "z")

NO_DISTANCE = 1e-30
"""m2; a squared distance below this counts as zero, so that the norm has a derivative there."""

Vector = tuple[Number, Number, Number]


class Frame(NamedTuple):
    """A frame: its axes and its origin in the coordinates of the arm's base."""

    x: Vector
    y: Vector
    z: Vector
    origin: Vector


BASE = Frame((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


def derive(p: Record) -> Values:
    """Cosines and sines of the twists, which do not change in a run."""
    return {"twist_cosine": cos(p.link_twist), "twist_sine": sin(p.link_twist)}


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Tool point, its error and its sensitivities to the elongations, in m and 1."""
    frames = chain(u.angle, p)
    directions = [growth_direction(frame, p, i) for i, frame in enumerate(frames)]
    sensitivity = [stack(*(each[k] for each in directions)) for k in range(3)]
    remaining = u.elongation - u.correction
    nominal = frames[-1].origin
    moved = [total(row * u.elongation) for row in sensitivity]
    error = [total(row * remaining) for row in sensitivity]
    return {
        "nominal_position": stack(*nominal),
        "position": stack(*(nominal[k] + moved[k] for k in range(3))),
        "error": stack(*error),
        "error_norm": norm(error),
        "uncompensated_error": stack(*moved),
        "uncompensated_error_norm": norm(moved),
        **{f"sensitivity_{name}": row for name, row in zip(COORDINATES, sensitivity, strict=True)},
    }


def chain(angle: Number, p: Record) -> list[Frame]:
    """Frames of all links at joint angles in rad; the last one's origin is the tool point."""
    frames = []
    frame = BASE
    for i in range(AXES):
        frame = next_frame(frame, angle[i] + p.joint_offset[i], p, i)
        frames.append(frame)
    return frames


def next_frame(before: Frame, angle: Number, p: Record, i: int) -> Frame:
    """Frame of link i from the one before it: Rot(z, angle) Trans(z, d) Trans(x, a) Rot(x, twist)."""
    c, s = cos(angle), sin(angle)
    x = combined(before.x, c, before.y, s)
    across = combined(before.x, -s, before.y, c)
    y = combined(across, p.twist_cosine[i], before.z, p.twist_sine[i])
    z = combined(across, -p.twist_sine[i], before.z, p.twist_cosine[i])
    along = combined(before.z, p.link_offset[i], x, p.link_length[i])
    return Frame(x, y, z, combined(before.origin, 1.0, along, 1.0))


def growth_direction(frame: Frame, p: Record, i: int) -> Vector:
    """Direction, in base coordinates, in which link i's growth moves what lies beyond it."""
    sideways = combined(frame.x, p.growth_x[i], frame.y, p.growth_y[i])
    return combined(sideways, 1.0, frame.z, p.growth_z[i])


def norm(vector: list[Number]) -> Number:
    """Length of a vector of three."""
    square = vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2
    return where(square > NO_DISTANCE, sqrt(maximum(square, NO_DISTANCE)), 0.0)


def combined(a: Vector, by: Number, b: Vector, times: Number) -> Vector:
    """Vector a, `by` times, plus b, `times` times."""
    return (a[0] * by + b[0] * times, a[1] * by + b[1] * times, a[2] * by + b[2] * times)
