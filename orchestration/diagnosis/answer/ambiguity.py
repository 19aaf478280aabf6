"""An ambiguous set in few words: which causes may replace which."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

Titles = frozenset[str]


def stand_ins(best: Titles, rivals: Sequence[Titles]) -> list[list[str]]:
    """Causes that the data cannot tell apart, one of the best set first in each list.

    Two sets that differ in one cause show that these two causes may replace each other. A set that follows
    from the best one by such exchanges is not listed again; any other is, as a combination written `a+b`.

    Parameters
    ----------
    best : titles of the chosen causes
    rivals : titles of each other set, best first
    """
    members = (best, *rivals)
    group = {title: {title} for member in members for title in member}
    for one, other in combinations(members, 2):
        (gone, come) = one - other, other - one
        if len(gone) == len(come) == 1:
            joined = group[next(iter(gone))] | group[next(iter(come))]
            group.update(dict.fromkeys(joined, joined))
    order = list(dict.fromkeys(title for member in members for title in sorted(member)))
    told: dict[Titles, list[str]] = {}
    for title in sorted(best, key=order.index):
        if len(group[title]) > 1:
            told.setdefault(
                frozenset(group[title]), [title, *(t for t in order if t in group[title] and t != title)]
            )
    for rival in sorted(rivals, key=lambda each: len(each - best)):
        own, other = best - rival, rival - best
        if not own:  # the same causes, and perhaps one more
            own, other = best, rival
        elif {id(group[title]) for title in own} == {id(group[title]) for title in other}:
            continue
        told.setdefault(own, ["+".join(sorted(own))]).append("+".join(sorted(other)))
    return list(told.values())


def differences(best: Titles, rivals: Sequence[Titles]) -> list[tuple[str, str]]:
    """Causes in which each rival differs from the best set: those it lacks, and those it has instead.

    One side is empty where a rival has only more or only fewer causes. A difference that contains another
    one is left out.
    """
    found = list(dict.fromkeys((best - rival, rival - best) for rival in rivals))
    least = [
        (own, other)
        for own, other in found
        if not any(a and b and a <= own and b <= other and (a, b) != (own, other) for a, b in found)
    ]
    return [("+".join(sorted(own)), "+".join(sorted(other))) for own, other in least]
