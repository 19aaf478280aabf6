"""The link's finite-volume grid: nodes that lie on the base and tip positions whatever these are."""

from dataclasses import dataclass

from warmlink.fmus.component import Record
from warmlink.fmus.component.arithmetic import Number, clip, maximum, stack

SMALLEST_STRETCH = 1e-6
"""Least length of a stretch as a share of the link's; an overhang of no length keeps its nodes."""


@dataclass(frozen=True)
class Stretches:
    """Intervals of the grid in each of the three stretches that base and tip position cut the link into."""

    before_base: int
    between: int
    after_tip: int

    @property
    def base_node(self) -> int:
        """Index of the node at base position."""
        return self.before_base

    @property
    def tip_node(self) -> int:
        """Index of the node at tip position."""
        return self.before_base + self.between


def stretches(cells: int) -> Stretches:
    """Share the intervals between `cells` nodes out over the three stretches.

    The overhangs get about the share that they have of the nominal link.
    """
    intervals = cells - 1
    before, after = max(2, round(0.08 * intervals)), max(2, round(0.05 * intervals))
    return Stretches(before, intervals - before - after, after)


def spacings(p: Record, cells: int) -> Number:
    """Distances in m between neighbouring nodes, shape (cells - 1,)."""
    smallest = SMALLEST_STRETCH * p.length
    parts = stretches(cells)
    lengths = (
        (maximum(p.base_position, smallest), parts.before_base),
        (p.tip_position - p.base_position, parts.between),
        (maximum(p.length - p.tip_position, smallest), parts.after_tip),
    )
    return stack(*(length / count for length, count in lengths for _ in range(count)))


def control_widths(step: Number) -> Number:
    """Length in m of the link that belongs to each node, shape (cells,), from the distances."""
    return (stack(0.0, step) + stack(step, 0.0)) / 2


def positions(p: Record, step: Number) -> Number:
    """Distances in m of the nodes from the end nearer the base, shape (cells,), from those between them."""
    intervals = step.shape[0]
    base = stretches(intervals + 1).base_node
    places = [p.base_position]
    for i in range(base - 1, -1, -1):
        places.insert(0, places[0] - step[i])
    for i in range(base, intervals):
        places.append(places[-1] + step[i])
    return stack(*places)


def interpolation_weights(places: Number, step: Number, place: Number) -> Number:
    """Weights of the nodes, shape (cells,), that interpolate linearly to a place in m."""
    share = clip((place - places[:-1]) / step, 0.0, 1.0)
    return stack(1.0, share) - stack(share, 0.0)
