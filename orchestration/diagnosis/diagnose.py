"""From a file of measurements to a diagnosis: verdict, causes, gain, and what to measure next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.data.columns import NOTHING_SAID, Said
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_runs
from warmlink.orchestration.diagnosis.data.inputs import with_inputs, with_nominal
from warmlink.orchestration.diagnosis.fit.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.fit.verdict import assess

if TYPE_CHECKING:
    import pandas as pd

Progress = Callable[[str], None]


def read(
    sources: Sequence[Path | str | pd.DataFrame],
    assumed: Sequence[str] = (),
    settings: Mapping[str, str] = MappingProxyType({}),
    told: Said = NOTHING_SAID,
) -> Experiment:
    """What a diagnosis works on, of measured runs together or of an experiment.

    Parameters
    ----------
    sources : an experiment file (TOML), or files or DataFrames measured on one warm-up cell
    assumed : `NAME=VALUE` of inputs that were not logged
    settings : values with units of parameters by which the system differs from the nominal one
    told : units and names of columns that the user gave

    Raises
    ------
    InputError
        A file, or something in it, cannot be used.
    """
    experiment = read_runs([Path(each) if isinstance(each, str) else each for each in sources], told)
    return with_inputs(with_nominal(experiment, settings), assumed)


def diagnose_experiment(experiment: Experiment, progress: Progress = lambda text: None) -> Diagnosis:
    """Diagnose an experiment that was read or made."""
    refuse_senseless(experiment)
    assessment = assess(experiment, progress)
    progress("measuring the gain")
    found = Diagnosis(experiment, assessment)
    _ = found.held_out
    return found
