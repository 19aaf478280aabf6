"""A machine of a stranger's."""

from warmlink.orchestration.machine.machine import Machine

BENCH = Machine("LumpBench", "a lump on a bench", {"lump": "Lump"})
