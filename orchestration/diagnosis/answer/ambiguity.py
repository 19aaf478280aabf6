"""An ambiguous set in few words: which causes may replace which, and which differences can be told."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

Titles = frozenset[str]
Pair = tuple[Titles, Titles]

_MOST_TOLD = 4
"""Causes of a list that the words name."""


def stand_ins(best: Titles, rivals: Sequence[Titles]) -> list[list[str]]:
    """Causes that the data cannot tell apart, one of the best set first in each list.

    Two sets that differ in one cause show that these two causes may replace each other. A set that follows
    from the best one by such exchanges is not listed again; any other is, as a combination written `a+b`.
    Sets are titles of causes, rivals best first.
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
        told.setdefault(own, [*titles([own])]).extend(titles([other]))
    return list(told.values())


def titles(sets: Iterable[Titles]) -> tuple[str, ...]:
    """Each set of causes as it is written, `a+b`."""
    return tuple("+".join(sorted(each)) for each in sets)


def differences(best: Titles, rivals: Sequence[Titles]) -> list[tuple[str, ...]]:
    """Causes in which each rival differs from the best set: those it lacks, and those it has instead.

    One side is empty where a rival has only more or only fewer causes. A difference that contains another
    one is left out.
    """
    found = list(dict.fromkeys((best - rival, rival - best) for rival in rivals))
    return [
        titles((own, other))
        for own, other in found
        if not any(a and b and a <= own and b <= other and (a, b) != (own, other) for a, b in found)
    ]


def told_apart(best: Titles, rivals: Sequence[Titles]) -> str:
    """What tells the best set from rivals, in words; empty where there are none."""
    return ", and ".join(_in_words(differences(best, rivals)))


def indistinguishable(alike: Iterable[Pair]) -> str:
    """A sentence, after a blank, on sets that nothing tells apart; empty where there are none."""
    told: dict[frozenset[str], tuple[str, ...]] = {}
    for pair in (pair for one, other in alike for pair in differences(one, [other])):
        told.setdefault(frozenset(pair), pair)
    words = _in_words(told.values())
    return f" Nothing tells {', nor '.join(words)}." if words else ""


def _in_words(pairs: Iterable[tuple[str, ...]]) -> list[str]:
    """Differences in words, those of one cause together."""
    others: dict[str, list[str]] = {}
    for one, other in pairs:
        others.setdefault(one or other, []).append(other if one else "")
    words = []
    for one, each in others.items():
        names = [other for other in each if other]
        if len(names) < len(each):
            words.append(f"whether {one} is there")
        if len(names) > _MOST_TOLD + 1:
            names = [*names[:_MOST_TOLD], f"{len(names) - _MOST_TOLD} more"]
        if names:
            any_of_them = f"{', '.join(names[:-1])} or {names[-1]}" if names[1:] else names[0]
            words.append(f"{one} from {any_of_them}")
    return words
