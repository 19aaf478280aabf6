"""From a file of measurements to a diagnosis: verdict, causes, gain, and what to measure next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.gain import Scores
from warmlink.orchestration.diagnosis.answer.next_experiment import next_experiment
from warmlink.orchestration.diagnosis.data.experiment import Experiment, read_runs
from warmlink.orchestration.diagnosis.data.inputs import with_inputs
from warmlink.orchestration.diagnosis.data.nominal import with_nominal
from warmlink.orchestration.diagnosis.fit.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.fit.verdict import assess

Progress = Callable[[str], None]


def diagnose(
    *paths: Path | str,
    assumed: Sequence[str] = (),
    settings: Mapping[str, str] = MappingProxyType({}),
    progress: Progress = lambda text: None,
) -> Diagnosis:
    """Diagnose an experiment, or measured runs together.

    Parameters
    ----------
    paths : an experiment file (TOML), or CSV files of one warm-up cell
    assumed : `NAME=VALUE` of inputs that were not logged
    settings : values with units of parameters by which the system differs from the nominal one
    progress : told in a few words what is being done

    Raises
    ------
    InputError
        A file, or something in it, cannot be used.
    """
    progress("reading")
    experiment = with_nominal(read_runs([Path(path) for path in paths]), settings)
    return diagnose_experiment(with_inputs(experiment, assumed), progress)


def diagnose_experiment(experiment: Experiment, progress: Progress = lambda text: None) -> Diagnosis:
    """Diagnose an experiment that was read or made."""
    refuse_senseless(experiment)
    assessment = assess(experiment, progress)
    progress("measuring the gain")
    scores = Scores(experiment, assessment.noise)
    before = scores.predict(assessment.null)
    after = scores.predict(assessment.best) if assessment.best.items else before
    members = tuple(scores.predict(fit) for fit in assessment.rivals)
    proposed = None
    if assessment.word == "ambiguous":
        progress("choosing the next experiment")
        proposed = next_experiment(assessment, experiment)
    return Diagnosis(experiment, assessment, scores, before, after, members, proposed)
