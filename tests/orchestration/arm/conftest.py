"""FMUs for the arm's tests: native where something compiles, else Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from warmlink.orchestration.arm.chain import arm_chain, arm_values
from warmlink.orchestration.arm.program import Program
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.machine.machine import merged
from warmlink.orchestration.system.model import System, Value

Values = dict[str, dict[str, Value]]
MakeArm = Callable[..., System]


@pytest.fixture(scope="session")
def fmu_store() -> FmuStore:
    kinds = set(arm_chain(compensated=False).parts.values())
    return store(None, sorted(kinds), lambda text: None)


@pytest.fixture(scope="session")
def plain_arm(fmu_store: FmuStore) -> MakeArm:
    """Function that makes an arm without compensators, under a program."""

    def make(program: Program, count: int = 6, cut: bool = False, values: Values | None = None) -> System:
        machine = arm_chain(count, compensated=False)
        files = fmu_store.files(set(machine.parts.values()))
        driven = replace(program, axes=count).start_values()
        return machine.system(files, None, merged(arm_values(count, cut), driven, values or {}))

    return make


def load_program(name: str) -> Program:
    program = load_scenario(name).duty
    assert isinstance(program, Program)
    return program


@pytest.fixture(scope="session")
def inspection() -> Program:
    return load_program("six_axis_inspection")
