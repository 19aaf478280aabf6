"""FMUs for the arm's tests: native where something compiles, else Python."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from warmlink.orchestration.arm.blueprint import arm_blueprint, arm_values, axis_name, merged
from warmlink.orchestration.arm.program import Program, load_program
from warmlink.orchestration.arm.run import arm_kinds
from warmlink.orchestration.fmu_store import FmuStore, store
from warmlink.orchestration.system.model import System, Value

Values = dict[str, dict[str, Value]]
MakeArm = Callable[..., System]


@pytest.fixture(scope="session")
def fmu_store() -> FmuStore:
    return store(None, arm_kinds(None), lambda text: None)


@pytest.fixture(scope="session")
def plain_arm(fmu_store: FmuStore) -> MakeArm:
    """Function that makes an arm without compensators, under a program."""

    def make(program: Program, count: int = 6, cut: bool = False, values: Values | None = None) -> System:
        blueprint = arm_blueprint(count, compensated=False)
        files = fmu_store.files(set(blueprint.components.values()))
        duties: Values = {f"{axis_name(i)}.duty": program.duty_values(i) for i in range(1, count + 1)}
        poses: Values = {"poses": program.pose_values()}
        return blueprint.system(files, None, merged(arm_values(count, cut), duties, poses, values or {}))

    return make


@pytest.fixture(scope="session")
def inspection() -> Program:
    return load_program("six_axis_inspection")
