"""What a simulation gets wrong: asked for in one call, shown, and written as files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from warmlink.orchestration.console import Answer, remark
from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import cause_entry
from warmlink.orchestration.diagnosis.answer.extension import extended_values, kinds_needed
from warmlink.orchestration.diagnosis.data.accuracy import with_accuracy
from warmlink.orchestration.diagnosis.data.inputs import of_scenario, with_noise
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read, work_out
from warmlink.orchestration.diagnosis.terms.entries import content_with
from warmlink.orchestration.diagnosis.terms.equation import Equation, discovered, is_due
from warmlink.orchestration.diagnosis.terms.words import summary_with
from warmlink.orchestration.fmu_store import store
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.progress import spinner
from warmlink.orchestration.report.diagnosis import write_diagnosis


@dataclass(frozen=True, repr=False)
class Found(Answer):
    """What a simulation gets wrong, and why."""

    diagnosis: Diagnosis
    equation: Equation | None = None

    @property
    def verdict(self) -> str:
        """One of adequate, named, ambiguous, empirical, unknown."""
        return self.diagnosis.verdict

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes found, strongest first."""
        return tuple(item.title for item in self.diagnosis.causes)

    @property
    def extended(self) -> dict[str, float]:
        """Parameters of the extended model that differ from nominal, in SI units; `run` takes them."""
        if self.equation is not None and self.equation.extends:
            return dict(self.equation.extended[1])
        return extended_values(self.diagnosis.assessment.problem, self.diagnosis.handed_on.fit)

    def summary(self) -> str:
        """At most ten lines of plain words, and what was found of an equation if one was looked for."""
        return summary_with(self.diagnosis, self.equation)

    def to_dict(self) -> dict[str, Any]:
        """What stands in `diagnosis.json`."""
        return content_with(self.diagnosis, self.equation)

    def to_frame(self) -> pd.DataFrame:
        """A row for each parameter of the causes found: value, unit and 95 % interval."""
        entries = [cause_entry(self.diagnosis, item) for item in self.diagnosis.causes]
        rows = [
            {"cause": entry["name"], "parameter": name, **figures}
            for entry in entries
            for name, figures in entry["parameters"].items()
        ]
        return pd.DataFrame(rows, columns=["cause", "parameter", "value", "std", "low95", "high95", "unit"])

    def write(self, folder: str | Path) -> dict[str, Path]:
        """Write the page, `diagnosis.json`, the extended model, and the next experiment if one is proposed.

        Parameters
        ----------
        folder : where to; what an earlier diagnosis left there goes

        Returns
        -------
        dict
            path of each file by its name, as `extended.ssp`

        Raises
        ------
        InputError
            If the folder holds another command's results, or cannot be written.
        """
        needed = kinds_needed(self.diagnosis.experiment.rig)
        return write_diagnosis(self.diagnosis, Path(folder), store(None, needed, remark), self.equation)


def diagnose(
    *sources: str | Path | pd.DataFrame,
    assume: Mapping[str, str | float] = MappingProxyType({}),
    parameters: Mapping[str, str] = MappingProxyType({}),
    scenario: str | Path | None = None,
    noise: Mapping[str, str] = MappingProxyType({}),
    accuracy: str | Mapping[str, str] = MappingProxyType({}),
    units: Mapping[str, str] = MappingProxyType({}),
    names: Mapping[str, str] = MappingProxyType({}),
    decimal: str = "",
    discover: bool | None = None,
) -> Found:
    """Show what the simulation gets wrong and name the cause.

    Parameters
    ----------
    sources : files or DataFrames measured on one machine, a warm-up cell unless `scenario` says otherwise,
        with columns as `tip_temperature [degC]`; or an experiment (TOML)
    assume : inputs that were not logged, as `{"torque": 0, "ambient_temperature": "22 degC"}`
    parameters : what is known to differ from nominal, `"800 mm"` under `link.length`
    scenario : a scenario (TOML) of the machine as it is known, which need not be a warm-up cell
    noise : 1 sigma by column or variable, `"0.1 K"` under `tip_temperature`
    accuracy : error that matters, `"0.5 K"` for all temperatures, or by column or variable; a model below it
        is adequate, however small the noise
    units : those that headers lack, `"degC"` under `T_base`
    names : what columns are, `"base_temperature"` under `T_base`; "" leaves the column out
    decimal : decimal mark, "point" or "comma", if a file could be read either way
    discover : whether to look for an equation of the heat that the model lacks, which `equation` of what is
        returned holds; None where no cause is established

    Raises
    ------
    InputError
        If a source, or something in it, cannot be used.

    Examples
    --------
    >>> found = wl.diagnose("run.csv")
    >>> print(found.verdict, found.causes)
    >>> found.write("found")
    """
    machine, known = (DEFAULT, {}) if scenario is None else of_scenario(str(scenario))
    assumed = [f"{name}={value}" for name, value in assume.items()]
    with spinner("Diagnosing") as progress:
        progress("reading")
        options = ReadOptions(units, names=names, decimal=decimal, machine=machine)
        experiment = with_noise(read(sources, assumed, {**known, **parameters}, options), noise)
        wanted = [accuracy] if isinstance(accuracy, str) else [f"{n}={v}" for n, v in accuracy.items()]
        diagnosis = diagnose_experiment(with_accuracy(experiment, wanted), progress)
        equation = discovered(diagnosis, progress) if is_due(diagnosis, discover) else None
        diagnosis = diagnosis if equation is None else equation.diagnosis
        work_out(diagnosis, progress)
        found = Found(diagnosis, equation)
    for each in found.diagnosis.remarks:
        remark(each)
    return found
