"""What a log says beside the law: the worth of thermometers, whether it is long enough, what is left."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from warmlink.controllers.learning.learnt import Learnt
from warmlink.controllers.learning.line import Learner
from warmlink.controllers.learning.logs import BLOCKS, Examples, Log

Array = NDArray[np.float64]

ALL_SUBSETS = 8
"""Thermometers up to which every set of them is tried; of more, sets that grow by the best one."""


def worth(learnt: Learnt) -> dict[tuple[int, ...], float]:
    """Rms error in m of what was held out, by each set of thermometers that was tried."""
    rows, used, found = learnt.examples, learnt.used, {}

    def tried(chosen: tuple[int, ...]) -> float:
        found[chosen] = Learner(chosen, learnt.model).best(rows)[1].rms
        return found[chosen]

    if len(used) <= ALL_SUBSETS:
        for count in range(1, len(used) + 1):
            for chosen in combinations(used, count):
                tried(chosen)
        return found
    grown: tuple[int, ...] = ()
    while len(grown) < len(used):
        more = [tuple(sorted((*grown, i))) for i in used if i not in grown]
        grown = min(more, key=tried)
    return found


def learning_curve(
    learnt: Learnt, minutes: Sequence[float] = (10, 20, 30, 60, 120, 240, 480)
) -> dict[float, float]:
    """Rms error in m of all that follows, by minutes of log that were learnt from."""
    rows, found = learnt.examples, {}
    lengths = [float(rows.time[rows.log == i].max()) for i in range(int(rows.log.max()) + 1)]
    passed = rows.time + np.append(0.0, np.cumsum(lengths))[rows.log]
    learner = Learner(learnt.used, learnt.model)
    for each in minutes:
        known = passed <= 60 * each
        if np.count_nonzero(known) < 2 * (len(learnt.used) + 3) or passed.max() < 75 * each:
            continue
        begun = rows.part(known)
        block = (BLOCKS * np.arange(begun.growth.size)) // begun.growth.size
        begun = Examples(begun.temperature, begun.growth, block, begun.log, begun.time)
        rest = rows.part(~known)
        line = learner.line(begun, learner.best(begun)[0])
        error = rest.growth - line.at(rest.temperature[:, learnt.used])
        found[float(each)] = float(np.sqrt(np.mean(error**2)))
    return found


def correlations(learnt: Learnt, logs: Sequence[Log]) -> dict[str, float]:
    """Correlation of what the law leaves with other signals, by their names, the largest first."""
    rows = learnt.examples
    left = rows.growth - learnt.line.at(rows.temperature[:, learnt.used])
    found = {}
    for name in logs[0].others:
        signal = np.concatenate(
            [
                np.interp(rows.time[rows.log == i] + log.time[0], log.time, log.others[name])
                for i, log in enumerate(logs)
                if name in log.others
            ]
        )
        if signal.size == left.size and np.std(signal) > 0 and np.std(left) > 0:
            found[name] = float(np.corrcoef(signal, left)[0, 1])
    return dict(sorted(found.items(), key=lambda each: -abs(each[1])))
