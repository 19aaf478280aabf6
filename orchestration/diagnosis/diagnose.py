"""From a file of measurements to a diagnosis: verdict, causes, gain, and what to measure next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from warmlink.orchestration.diagnosis.ambiguity import stand_ins
from warmlink.orchestration.diagnosis.compensation import Compensated, feed_forward, observer
from warmlink.orchestration.diagnosis.experiment import Experiment, read_runs
from warmlink.orchestration.diagnosis.extension import extended_values, write_ssp_of, write_ssv_of
from warmlink.orchestration.diagnosis.fitting import Fit
from warmlink.orchestration.diagnosis.gain import Predicted, Scores
from warmlink.orchestration.diagnosis.inputs import with_inputs
from warmlink.orchestration.diagnosis.next_experiment import Proposed, next_experiment
from warmlink.orchestration.diagnosis.nominal import with_nominal
from warmlink.orchestration.diagnosis.problem import Item
from warmlink.orchestration.diagnosis.residuals import Wrong, what_is_wrong
from warmlink.orchestration.diagnosis.sensible import refuse_senseless
from warmlink.orchestration.diagnosis.unknown import Hint, hint
from warmlink.orchestration.diagnosis.verdict import Assessment, assess
from warmlink.orchestration.diagnosis.writing import SHOWN, cause_entry, shown, summary_lines

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

Progress = Callable[[str], None]

SSV, SSP, JSON = "extended.ssv", "extended.ssp", "diagnosis.json"


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


@dataclass(frozen=True)
class Diagnosis:
    """All that was found; `to_json` gives it in the form of `diagnosis.json`.

    Attributes
    ----------
    experiment : what was measured
    assessment : the search and its verdict
    scores : errors on the whole experiment
    before, after : readings by the uncorrected and by the chosen model
    members : readings by the rivals of an ambiguous verdict
    proposed : the next experiment, where the verdict is ambiguous
    """

    experiment: Experiment
    assessment: Assessment
    scores: Scores
    before: Predicted
    after: Predicted
    members: tuple[Predicted, ...]
    proposed: Proposed | None

    @property
    def verdict(self) -> str:
        """One of adequate, named, ambiguous, unknown."""
        return self.assessment.word

    @property
    def causes(self) -> tuple[Item, ...]:
        """Causes found, strongest first; of an ambiguous set the best member."""
        if self.verdict in ("adequate", "unknown"):
            return ()
        return tuple(sorted(self.assessment.best.items, key=lambda item: -self.strength(item)))

    def strength(self, item: Item) -> float:
        """Chi-square that the chosen model loses without a cause."""
        fit = self.assessment.best
        values = np.array([v for f, v in zip(fit.freed, fit.theta, strict=True) if f in item.freed])
        which = [i for i, f in enumerate(fit.freed) if f in item.freed]
        neutral = np.array([fit.freed[i].start for i in which])
        covariance = fit.covariance()[np.ix_(which, which)]
        away = values - neutral
        return float(away @ np.linalg.pinv(covariance, hermitian=True) @ away)

    @cached_property
    def ambiguous(self) -> list[list[str]]:
        """Sets of causes that the data cannot tell apart; a combination is written `a+b`."""
        if self.verdict != "ambiguous":
            return []
        return stand_ins(self.assessment.best.key, [fit.key for fit in self.assessment.rivals])

    @cached_property
    def wrong(self) -> dict[str, Wrong]:
        """What the simulation as it stands gets wrong, by column name."""
        return what_is_wrong(self.assessment.fitter, self.assessment.null)

    @cached_property
    def remaining(self) -> dict[str, Wrong]:
        """What is wrong still with the chosen model."""
        return what_is_wrong(self.assessment.fitter, self.assessment.best)

    @cached_property
    def hint(self) -> Hint | None:
        """For an unknown cause what the missing heat looks like."""
        return hint(self.assessment) if self.verdict == "unknown" else None

    @property
    def adopted(self) -> Predicted:
        """Readings by the model to use from now on."""
        return self.after if self.causes else self.before

    def chosen(self) -> Fit:
        """The model to use from now on: the uncorrected one unless causes were found."""
        return self.assessment.best if self.causes else self.assessment.null

    @cached_property
    def feed_forward(self) -> tuple[Compensated, Compensated] | None:
        """Largest error of the model as a feed-forward, before and after."""
        before, after = (feed_forward(self.scores.problem, p) for p in (self.before, self.adopted))
        return None if before is None or after is None else (before, after)

    @cached_property
    def observer(self) -> tuple[Compensated, Compensated] | None:
        """Largest error of the observer designed on the model, before and after."""
        null, chosen = self.assessment.null, self.chosen()
        before = observer(self.scores.problem, null, chosen)
        after = before if chosen is null else observer(self.scores.problem, chosen, chosen)
        return None if before is None or after is None else (before, after)

    def units(self) -> dict[str, str]:
        """Unit of each measured column by its name, as the file has it."""
        return {c.name: c.unit for c in self.experiment.columns}

    def to_json(self, ssv: str | None = None, ssp: str | None = None) -> dict[str, Any]:
        """Contents of `diagnosis.json`; values in the units that the keys `unit` tell."""
        proposed = self.proposed
        return {
            "verdict": self.verdict,
            "causes": [cause_entry(self, item) for item in self.causes],
            "ambiguous": self.ambiguous,
            "next_experiment": None
            if proposed is None
            else {
                "duty": [vars(stage) for stage in proposed.duty],
                "why": proposed.why,
                "expected_separation_sigma": proposed.expected_separation_sigma,
                "expected_chance": proposed.expected_chance,
                "alike": [list(pair) for pair in proposed.alike],
            },
            "wrong": {name: self._wrong_entry(name, wrong) for name, wrong in self.wrong.items()},
            "remaining": {name: self._wrong_entry(name, wrong) for name, wrong in self.remaining.items()},
            "artefacts": {
                "communication_step": {
                    "solved_in_one_piece": True,
                    "error_sigma": self.assessment.artefact,
                }
            },
            "hint": None if self.hint is None else self.hint.to_json(),
            "gain": self._gain(),
            "extended": {"ssv": ssv, "ssp": ssp},
            "remarks": list(self.experiment.remarks),
        }

    def summary(self) -> str:
        """Ten lines at most, in plain words."""
        return "\n".join(summary_lines(self))

    def write(self, folder: Path, store: FmuStore | None = None) -> dict[str, Path]:
        """Write `diagnosis.json`, the report and the extended model.

        Parameters
        ----------
        folder : where; made if need be
        store : FMUs for the extended `.ssp`; without, only the `.ssv` is written

        Returns
        -------
        dict
            Paths by name of the file.
        """
        import json

        from warmlink.orchestration.diagnosis.report import write_report
        from warmlink.orchestration.files import fresh_folder

        values = extended_values(self.assessment.problem, self.chosen())
        with fresh_folder(folder) as work:
            write_ssv_of(values, work / SSV)
            if store is not None:
                write_ssp_of(self.experiment.rig.name, values, work / SSP, store)
            content = self.to_json(SSV, SSP if store is not None else None)
            text = json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False)
            (work / JSON).write_text(text + "\n", encoding="utf-8")
            write_report(self, work / "report.html")
            names = [path.name for path in work.iterdir()]
        return {name: folder / name for name in names}

    def _wrong_entry(self, name: str, wrong: Wrong) -> dict[str, Any]:
        unit = shown(self.units()[name])
        return {
            "unit": unit,
            "rmse": wrong.rmse * SHOWN[unit],
            "noise": wrong.noise * SHOWN[unit],
            "bias": wrong.bias * SHOWN[unit],
            "whiteness_p": wrong.whiteness_p,
            "when": list(wrong.when),
            "correlates_with": [{"signal": signal, "r": r} for signal, r in wrong.correlates_with],
        }

    def _gain(self) -> dict[str, Any]:
        heldout = self._rmse(self.adopted, True)
        if self.verdict == "ambiguous" and heldout is not None:
            heldout["members"] = {
                name: {**(self._rmse(each, True) or {}), "runs": self._runs(each)}
                for name, each in ((p.name, p) for p in (self.after, *self.members))
            }
        return {
            "fit": self._rmse(self.adopted, False),
            "heldout": heldout,
            "runs": self._runs(self.adopted),
            "compensation_um": None
            if self.feed_forward is None
            else {
                **_in_um(self.feed_forward),
                "observer": None if self.observer is None else _in_um(self.observer),
            },
        }

    def _rmse(self, after: Predicted, heldout: bool) -> dict[str, Any] | None:
        first, then = self.scores.rmse(self.before, heldout), self.scores.rmse(after, heldout)
        if first is None or then is None:
            return None
        return {
            "rmse_before": first[0],
            "rmse_after": then[0],
            "rmse_before_95": list(first[1:]),
            "rmse_after_95": list(then[1:]),
        }

    def _runs(self, after: Predicted) -> dict[str, dict[str, dict[str, Any]]]:
        result: dict[str, dict[str, dict[str, Any]]] = {}
        tables = zip(
            self.experiment.runs,
            self.scores.by_channel(self.before),
            self.scores.by_channel(after),
            strict=True,
        )
        for run, first, then in tables:
            result[run.name] = {}
            for name, value in first.items():
                unit = shown(self.units()[name])
                factor = SHOWN[unit]
                result[run.name][name] = {
                    "rmse_before": value * factor,
                    "rmse_after": then[name] * factor,
                    "unit": unit,
                }
        return result


def _in_um(pair: tuple[Compensated, Compensated]) -> dict[str, Any]:
    before, after = pair
    return {
        "before": 1e6 * before.largest,
        "after": 1e6 * after.largest,
        "before_95": [1e6 * before.low95, 1e6 * before.high95],
        "after_95": [1e6 * after.low95, 1e6 * after.high95],
    }
