"""Which joint of the arm is at fault, and what is wrong with it: a diagnosis of each axis."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from warmlink.orchestration.arm.chain import axis, axis_name
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.words import summary
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment
from warmlink.orchestration.progress import Progress, stretch, unseen

if TYPE_CHECKING:
    from warmlink.orchestration.diagnosis.data.experiment import Experiment


@dataclass(frozen=True)
class ArmDiagnosis:
    """A diagnosis for each axis, by its number."""

    axes: Mapping[int, Diagnosis]

    @property
    def by_name(self) -> dict[str, Diagnosis]:
        """The same by the axes' names, `axis1` and so on."""
        return {axis_name(number): each for number, each in self.axes.items()}

    @property
    def at_fault(self) -> tuple[int, ...]:
        """Numbers of the axes that something is wrong with."""
        return tuple(number for number, each in self.axes.items() if each.verdict != "adequate")

    def summary(self) -> str:
        """A line for each axis, and all that is said of those that something is wrong with."""
        lines = []
        for number, each in self.axes.items():
            found = " + ".join(item.title for item in each.causes)
            lines.append(f"{axis_name(number)}  {axis(number).name:<12}{each.verdict:<12}{found}".rstrip())
        for number in self.at_fault:
            lines += ["", summary(self.axes[number])]
        return "\n".join(lines)

    def to_json(self, ssv: str) -> dict[str, Any]:
        """Contents of `diagnosis.json`: the axes at fault, and each axis's own with its file `ssv`."""
        return {
            "at_fault": [axis_name(number) for number in self.at_fault],
            "axes": {name: json_content(each, ssv) for name, each in self.by_name.items()},
        }


def diagnose_arm(
    experiments: Mapping[int, Experiment],
    numbers: Iterable[int] | None = None,
    progress: Progress = unseen,
) -> ArmDiagnosis:
    """Diagnose each axis asked for, all by default."""
    found = {}
    asked = list(experiments if numbers is None else numbers)
    for k, number in enumerate(asked):
        name = f"{axis_name(number)}, {axis(number).name}"
        within = stretch(progress, k / len(asked), (k + 1) / len(asked))

        def about_axis(
            doing: str, share: float | None = None, /, name: str = name, within: Progress = within
        ) -> None:
            within(f"{name}: {doing}", share)

        found[number] = diagnose_experiment(experiments[number], about_axis)
    return ArmDiagnosis(found)
