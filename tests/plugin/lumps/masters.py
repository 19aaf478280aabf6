"""A master algorithm of a stranger's."""

from warmlink.orchestration.master.algorithms.explicit import GaussSeidel


class Reversed(GaussSeidel):
    """Gauss-Seidel under another name."""


REVERSED = Reversed()
