"""Master algorithms: explicit, iterated, in parts of a step; their table; and what they share."""

DEFAULT_MASTER = "gauss_seidel"
"""Name of the algorithm that runs what names none."""
