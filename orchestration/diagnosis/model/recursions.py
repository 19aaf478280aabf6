"""Numbers each of which follows from those before it."""

from __future__ import annotations

import numpy as np

from warmlink.orchestration.arrays import Array


def recursion(given: Array, by_last: Array) -> Array:
    """Solve x[k] = given[k] + sum over d from 1 of by_last[d - 1, k - d] x[k - d].

    Parameters
    ----------
    given : shape (n, columns), each a recursion of its own
    by_last : what each number adds to those after it, shape (reach, n)
    """
    from scipy.linalg.lapack import dtbtrs

    if not given.size:  # for which LAPACK's wrapper writes where it must not
        return given.copy()
    diagonals = np.vstack([np.ones(len(given)), -by_last])
    return np.asarray(dtbtrs(diagonals, given, uplo="L", diag="U")[0], dtype=np.float64)
