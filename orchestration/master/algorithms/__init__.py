"""Master algorithms: explicit, iterated, in parts of a step; their names; and what they share."""

DEFAULT_MASTER = "gauss_seidel"
"""Name of the algorithm that runs what names none."""

ERROR_CONTROLLED = "error_controlled"
"""Name of the algorithm whose steps follow the error."""
