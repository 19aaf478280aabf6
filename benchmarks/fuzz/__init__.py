"""Damaged input for every reader: `python -m benchmarks.fuzz --count 100000 --seed 1`.

Right is: taken, or refused in one sentence of warmlink's own, within ten seconds and one gigabyte, and
nothing is written outside the folder that was named.
"""
