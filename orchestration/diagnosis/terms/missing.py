"""Missing heat at each place that heat may enter: its course with a band, by the smoother.

Each place has a heat of its own, 0 as the model stands. What the readings answer to a course of it is known
from the simulation, so that the course follows from what a fit leaves, as an Ornstein-Uhlenbeck process of
the likeliest size (`fit/wandering.py`). The same answers tell what a term would gain, before it is simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from warmlink.fmus.heat_term.component import HeatTerm
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.diagnosis.data.experiment import Calibration
from warmlink.orchestration.diagnosis.fit.algebra import orthonormal
from warmlink.orchestration.diagnosis.fit.fitting import Fitter, by_number
from warmlink.orchestration.diagnosis.fit.verdict import Assessment
from warmlink.orchestration.diagnosis.model.integrator import Courses
from warmlink.orchestration.diagnosis.terms.followed import TermSignals
from warmlink.orchestration.diagnosis.terms.library import Candidate
from warmlink.orchestration.diagnosis.terms.modelled import TermProblem, into, places_of
from warmlink.orchestration.machine.terms import PlacedTerm, with_terms

_SPACING, _MOST_NODES = 60.0, 150
"""s between the nodes of a course at least, and nodes of one run at most."""

_HEATS = tuple(0.05 * 2.0**k for k in range(11))
"""W, standard deviations of a course that are tried."""

_MEMORY = 900.0
"""s, for which a course remembers itself."""

_SIGMA = 1.96


@dataclass(frozen=True)
class PlaceHeat:
    """Missing heat in W at one place over one run, as if all of it entered there.

    Attributes
    ----------
    run, place : name of the run, and of the place
    time : s, shape (nodes,)
    heat, deviation : W, the course and its standard deviation, shape (nodes,) each
    misfit : minus twice the log-likelihood, by which places compare, all runs together
    """

    run: str
    place: str
    time: Array
    heat: Array
    deviation: Array
    misfit: float

    @property
    def sentence(self) -> str:
        """Say how large it is at most, with its band."""
        k = int(np.argmax(np.abs(self.heat)))
        way = "too little" if self.heat[k] > 0 else "too much"
        return (
            f"{self.place}: up to {abs(self.heat[k]):.2g} W {way} in the model, "
            f"at {self.time[k] / 60:.0f} min of {self.run} "
            f"(95 %: within {_SIGMA * self.deviation[k]:.2g} W)"
        )


class Missing:
    """What the readings answer to heat at each place, and what the model as it stands leaves of them."""

    def __init__(self, assessment: Assessment) -> None:
        experiment = assessment.problem.experiment
        rig, self.places = experiment.rig, places_of(experiment.rig)
        probes = {
            f"probe_{place}": PlacedTerm(HeatTerm("Probe", "q", {}, {"q": (0.0, "W")}), into(rig, place), {})
            for place in self.places
        }
        opened = tuple(Calibration(f"{name}.q", -1.0, 1.0, 0.0) for name in probes)
        probed = replace(
            experiment,
            rig=with_terms(rig, probes),
            calibrated=(*experiment.calibrated, *opened),
            declared=(),
            with_shipped=False,
        )
        self.assessment = assessment
        self.problem = TermProblem(probed, assessment.problem)
        old = assessment.fitter
        self.fitter = Fitter(self.problem, old.noise, old.wander, old.responses)
        self._own = [f for f in self.problem.calibrated if not f.variable.startswith("probe_")]
        start = {f.key: value for f, value in assessment.null.values.items()}
        self._theta = np.array([start.get(f.key, f.start) for f in self.problem.calibrated])
        self.values = self.problem.values_by_run(self.problem.calibrated, self._theta)
        slots = [(self.problem.slots.index(f"{name}.q"),) for name in probes]
        self.nodes: list[Array] = []
        self._answers: list[Array] = []
        self._left: list[Array] = []
        whitened = self.fitter.whitened(self.problem.calibrated, self._theta)
        for run, (z, joined) in enumerate(zip(self.values, whitened, strict=True)):
            span = float(self.problem.data[run].time[-1])
            count = int(np.clip(span / _SPACING, 4, _MOST_NODES)) + 1
            self.nodes.append(np.linspace(0.0, span, count))
            table = self.problem.responses(run, z, Courses(tuple(slots), self.nodes[-1]))
            self._answers.append(self.fitter.whiten(run, self.fitter.stacked(run, table)))
            self._left.append(joined)
        # What the user calibrates may move, so that it is taken out of both.
        taken = [by_number(j[:, 1:], self._own, r, self._own) for r, j in enumerate(self._left)]
        self._taken = orthonormal(np.concatenate(taken))
        self.followed = TermSignals(self.problem, self.values)
        edges = np.cumsum([0, *(len(each) for each in self._left)])
        self._rows = [slice(a, b) for a, b in pairwise(edges.tolist())]
        self.residual = self._free(np.concatenate([joined[:, 0] for joined in self._left]))

    def _free(self, columns: Array) -> Array:
        """Columns without what calibrated numbers explain."""
        return columns - self._taken @ (self._taken.T @ columns)

    def columns(self, candidates: Sequence[Candidate]) -> Array:
        """What the readings answer to candidates of 1 W, shape (rows, candidates).

        Whitened, and free of what is calibrated.
        """
        found = np.empty((self.residual.size, len(candidates)))
        for place in {each.place for each in candidates}:
            some = [i for i, each in enumerate(candidates) if each.place == place]
            heats = [self.followed.course(candidates[i]) for i in some]
            found[:, some] = self.answered(
                place, [np.column_stack(each) for each in zip(*heats, strict=True)]
            )
        return found

    def largest(self, candidate: Candidate) -> float:
        """Largest heat in W of a candidate of 1 W."""
        return max(float(np.abs(heat).max()) for heat in self.followed.course(candidate))

    def answered(self, place: str, courses: Sequence[Array]) -> Array:
        """What the readings answer to heat at a place, given at the rows of each run, shape (rows, ...)."""
        at_nodes = [onto @ heat for onto, heat in zip(self._onto, courses, strict=True)]
        return self._answers_at[place] @ np.concatenate(at_nodes)

    @cached_property
    def _onto(self) -> list[Array]:
        """By run, the matrix from heat at the rows to a broken line through the nodes."""
        every = zip(self.nodes, self.problem.experiment.runs, strict=True)
        return [_onto(nodes, run.time) for nodes, run in every]

    @cached_property
    def _answers_at(self) -> dict[str, Array]:
        """By place, what the readings of all runs answer to heat at the nodes of all runs."""
        from scipy.linalg import block_diag

        found = {}
        for which, place in enumerate(self.places):
            parts = zip(self._answers, self.nodes, strict=True)
            each = [table[:, which * n.size : (which + 1) * n.size] for table, n in parts]
            found[place] = self._free(block_diag(*each))
        return found

    def heat(self) -> tuple[PlaceHeat, ...]:
        """The course at each place by run, the likeliest place first."""
        found: list[PlaceHeat] = []
        for which, place in enumerate(self.places):
            parts = [self._free_of_run(run, which) for run in range(len(self.nodes))]
            sizes = [(sum(_misfit(*part, size) for part in parts), size) for size in _HEATS]
            misfit, size = min(sizes)
            for run, (answers, left, apart) in enumerate(parts):
                mean, deviation = _smoothed(answers, left, apart, size)
                name = self.problem.experiment.runs[run].name
                found.append(PlaceHeat(name, place, self.nodes[run], mean, deviation, misfit))
        return tuple(sorted(found, key=lambda each: each.misfit))

    def _free_of_run(self, run: int, which: int) -> tuple[Array, Array, Array]:
        """Answers at a place, what is left, and the times between nodes of one run."""
        size = self.nodes[run].size
        answers = self._answers[run][:, which * size : (which + 1) * size]
        apart = np.abs(np.subtract.outer(self.nodes[run], self.nodes[run]))
        return answers, self.residual[self._rows[run]], apart


def _onto(nodes: Array, time: Array) -> Array:
    """Matrix from heat that holds from row to row to the nodes of the broken line nearest to it."""
    fine = np.linspace(nodes[0], nodes[-1], 8 * (nodes.size - 1) + 1)
    fine = (fine[1:] + fine[:-1]) / 2
    rows = np.clip(np.searchsorted(time, fine, side="right") - 1, 0, time.size - 1)
    place = np.clip(np.searchsorted(nodes, fine, side="right") - 1, 0, nodes.size - 2)
    share = (fine - nodes[place]) / (nodes[place + 1] - nodes[place])
    gram, right = np.zeros((2, nodes.size)), np.zeros((nodes.size, time.size))
    np.add.at(gram[1], place, (1 - share) ** 2)
    np.add.at(gram[1], place + 1, share**2)
    np.add.at(gram[0], place + 1, share * (1 - share))
    np.add.at(right, (place, rows), 1 - share)
    np.add.at(right, (place + 1, rows), share)
    from scipy.linalg import solveh_banded

    return np.asarray(solveh_banded(gram, right))


def _misfit(answers: Array, left: Array, apart: Array, size: float) -> float:
    root = size * np.linalg.cholesky(np.exp(-apart / _MEMORY) + 1e-9 * np.eye(len(apart)))
    columns = answers @ root
    factor = np.linalg.cholesky(np.eye(len(root)) + columns.T @ columns)
    part = np.linalg.solve(factor, columns.T @ left)
    return float(left @ left - part @ part + 2 * np.log(np.diag(factor)).sum())


def _smoothed(answers: Array, left: Array, apart: Array, size: float) -> tuple[Array, Array]:
    root = size * np.linalg.cholesky(np.exp(-apart / _MEMORY) + 1e-9 * np.eye(len(apart)))
    columns = answers @ root
    covariance = root @ np.linalg.solve(np.eye(len(root)) + columns.T @ columns, root.T)
    return covariance @ (answers.T @ left), np.sqrt(np.maximum(np.diag(covariance), 0.0))
