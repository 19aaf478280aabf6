"""The observer with two more disturbances, which the camera's readings of the remaining error reveal.

    elongation = (1 + s) (e z - e_1 (T_ref - T_0)) + o

s is the expansion coefficient's relative error, nearly constant; o a slow error that no temperature explains.
A reading measures elongation minus correction when the picture was taken, so with the correction added it
measures the elongation: whatever constant error the model makes ends in s and o, and the correction is free
of it. The camera teaches s and o alone, and these within bounds; a camera that lies cannot move the
temperatures.
U. Maeder, F. Borrelli and M. Morari, "Linear offset-free model predictive control", Automatica 45 (2009)
2214-2222, on disturbances that make an observer offset-free.
"""

from functools import partial
from typing import NamedTuple

from warmlink.controllers import fail_safe
from warmlink.controllers.interface import SIGMAS
from warmlink.controllers.kalman import Belief, CrossCovariance, cross_covariance, gain_of, updated_in_part
from warmlink.controllers.matrices import dot
from warmlink.controllers.observer import law as observer
from warmlink.controllers.observer import model
from warmlink.controllers.observer.filters import Filters, evidence, filters_of, led, together
from warmlink.controllers.observer.witnesses import Look
from warmlink.fmus.calls import as_c_function, skip_if_zero, vectorised_pair
from warmlink.fmus.component import Record, Values
from warmlink.fmus.component.arithmetic import (
    LARGEST,
    Number,
    absolute,
    clip,
    exp,
    finite,
    maximum,
    side,
    stack,
    truth,
    where,
)

DISTURBANCES = model.HEATS + 2
"""Unknown heats, then the relative error of the expansion coefficient and the offset."""

STATES = model.MODES + DISTURBANCES

_SCALE, _OFFSET = STATES - 2, STATES - 1

_TAUGHT = (model.HEATS, DISTURBANCES)
"""Which of the disturbances the camera reveals, and may change."""

_AT_BOUND = 1.0 - 1e-6
"""Share of its authority at which the camera's teaching counts as held back."""


LARGEST_LEARNT = 0.8
"""Share of the tolerance beyond which camera and temperatures differ too much for either to be relied on."""


class Camera(NamedTuple):
    """What is remembered of the camera.

    Attributes
    ----------
    last, age : its last reading in m, and that reading's age in s
    calm_for, out : how it is trusted, as in `fail_safe.Trust`
    free_for : time in s that no limit has held the correction back
    evidence : how strong what it teaches is seen to be, as in `filters.evidence`
    says, said : elongation in m that it last told while no limit acted, and 1 once it did
    denies : by how much in m that was beyond what the temperatures made then
    """

    last: Number
    age: Number
    calm_for: Number
    out: Number
    free_for: Number
    evidence: Number
    says: Number
    said: Number
    denies: Number


CAMERA_UNITS = Camera(
    last="m", age="s", calm_for="s", out="1", free_for="s", evidence="1", says="m", said="1", denies="m"
)
"""Units of the states that hold it."""


def begin(u: Record, p: Record) -> Values:
    """States at the start: those of the observer, and no reading of the camera yet."""
    drift = where(finite(u.measured_drift), u.measured_drift, 0.0)
    return {**observer.begun(u, p, STATES, elongation), **_named(Camera(drift, *[0.0] * 8))}


def update(x: Record, u: Record, p: Record, time: Number, step: Number) -> Values:
    """States after a sample: the observer's, then what the camera teaches, limited."""
    sample = observer.sampled(x, u, p, step, STATES)
    filters, camera = update_from_camera(sample.filters, x, u, p, step)
    seen = evidence(x.evidence, filters, observer.HEAT, p, sample.heard)
    camera_seen = evidence(x.camera_evidence, filters, _TAUGHT, p, 1.0)
    filters = led(filters, seen, sample.again, p)
    by_temperature = model.elongation(filters.quiet.mean, p)
    learnt = added_by_camera(filters.quiet.mean, by_temperature)
    valid = truth(u.drift_valid > 0.5)
    witness = Look(camera.says, valid * watching(camera, p), camera.denies)
    wanted, states = observer.settled(x, sample, filters, by_temperature, p, step, learnt, witness)
    free = where(absolute(wanted - states["correction"]) < p.camera_std, camera.free_for + step, 0.0)
    shown = maximum(valid * absolute(camera.last), absolute(learnt) / LARGEST_LEARNT)
    off = truth(shown > p.tolerance)
    distrusted = maximum(states["distrusted"], doubtful(camera, filters.quiet, u, p))
    later = {
        **observer.named(filters, sample.trust, seen),
        **_named(camera._replace(free_for=free, evidence=camera_seen)),
        **states,
        "elongation": wanted,
        "doubt": maximum(maximum(states["doubt"], distrusted), off),
        "distrusted": distrusted,
    }
    return observer.begun_again(begin, later, sample, x, u, p, step)


def outputs(x: Record, u: Record, p: Record, time: Number) -> Values:
    """Correction and its uncertainty in m."""
    filters, camera = filters_of(x), Camera(*(getattr(x, f"camera_{name}") for name in Camera._fields))
    mean = filters.quiet.mean
    row = elongation_row(mean, p)
    followed = watching(camera, p) * (1.0 - camera.out)
    left = maximum(absolute(camera.last) - SIGMAS * p.camera_std, 0.0)
    return observer.reported(x, filters, elongation(mean, p), row, p, camera.evidence, followed, left)


def update_from_camera(
    filters: Filters, x: Record, u: Record, p: Record, step: Number
) -> tuple[Filters, Camera]:
    """Beliefs and memory after the camera's reading, which counts once, when it is new.

    While a limit holds the correction back, the reading is not the estimate's error; it counts only when the
    limits have been idle since before the picture was taken.
    """
    age = x.camera_age + step
    new = where(u.measured_drift == x.camera_last, 0.0, 1.0) * truth(u.drift_valid > 0.5)
    news = new * fail_safe.present(u.measured_drift)
    looked = news * truth(x.camera_free_for > p.camera_delay + 2.0 * step)
    measured = u.measured_drift + x.correction
    before = filters, x.camera_calm_for, x.camera_out
    expected = filters_of(x).mean
    filters, calm_for, out = _looked(before, expected, measured, age, p, looked)
    return filters._replace(mean=bounded(filters.mean, p)), Camera(
        last=where(news > 0, u.measured_drift, x.camera_last),
        age=where(news > 0, 0.0, age),
        calm_for=calm_for,
        out=out,
        free_for=x.camera_free_for,
        evidence=x.camera_evidence,
        says=where(looked > 0, measured, x.camera_says),
        said=where(looked > 0, 1.0, x.camera_said),
        denies=where(looked > 0, measured - model.elongation(side(1, expected), p), x.camera_denies),
    )


@skip_if_zero
def _looked(
    before: tuple[Filters, Number, Number],
    expected: Number,
    measured: Number,
    age: Number,
    p: Record,
    looked: Number,
) -> tuple[Filters, Number, Number]:
    """Beliefs, and how the camera is trusted, after a look of the camera.

    Parameters
    ----------
    before : beliefs, and `calm_for` and `out` of the camera
    expected : means of the beliefs when the picture was taken, beside which its elongation in m is judged
    age : time in s since the last reading
    """
    filters, calm_for, out = before
    variance = p.camera_std**2
    both = filters.alert, filters.quiet
    rows = [elongation_row(each.mean, p) for each in both]
    across = [cross_covariance(*each) for each in zip(both, rows, strict=True)]
    innovations = [measured - elongation(side(k, expected), p) for k in range(2)]
    # A leap within the camera's authority is harmless, so it is believed.
    by_all = dot(rows[0], across[0].spread)
    leap = (p.camera_authority / p.gate) ** 2
    widest = maximum(by_all, 0.0) + variance + leap
    sure = variance + leap / fail_safe.RETURN_GATE**2
    memory = fail_safe.Memory(0.0, calm_for, out)
    gates = fail_safe.Gates(p.gate, LARGEST, 1.0 - exp(-age / p.mean_time), p.camera_return_time)
    use, memory = fail_safe.gate_reading(memory, looked, innovations[1], widest, sure, gates, age)
    seen = zip(both, across, rows, innovations, strict=True)
    filters = together(*(_updated_by_camera(*each, variance, use) for each in seen))
    return filters, where(looked > 0, memory.calm_for, calm_for), where(looked > 0, memory.out, out)


@as_c_function
def _updated_by_camera(
    belief: Belief, across: CrossCovariance, row: Number, innovation: Number, variance: Number, use: Number
) -> Belief:
    """A belief after a look of the camera, which changes only what it reveals."""
    gain = gain_of(row, across, innovation, variance, use)
    return updated_in_part(belief, across, gain, row, variance, _TAUGHT[1] - _TAUGHT[0])


@partial(vectorised_pair, paired=1)
def bounded(mean: Number, p: Record) -> Number:
    """The estimate with what the camera adds kept within its authority, lest it winds up beyond."""
    by_temperature = model.elongation(mean, p)
    bound = authority(by_temperature, p)
    scale = clip(mean[_SCALE], -p.camera_relative_authority, p.camera_relative_authority)
    added = clip(scale * by_temperature + mean[_OFFSET], -bound, bound)
    return stack(mean[:_SCALE], scale, added - scale * by_temperature)


def elongation(mean: Number, p: Record) -> Number:
    """Elongation in m: by the temperatures, and what the camera adds to it."""
    by_temperature = model.elongation(mean, p)
    return by_temperature + added_by_camera(mean, by_temperature)


def added_by_camera(mean: Number, by_temperature: Number) -> Number:
    """Elongation in m that the camera has added."""
    return mean[_SCALE] * by_temperature + mean[_OFFSET]


def authority(by_temperature: Number, p: Record) -> Number:
    """Elongation in m that the camera may add at most."""
    return p.camera_authority + p.camera_relative_authority * absolute(by_temperature)


def elongation_row(mean: Number, p: Record) -> Number:
    """Derivative of the elongation by the state, shape (11,)."""
    none = [0.0] * model.HEATS
    return stack((1.0 + mean[_SCALE]) * p.elongation_row, *none, model.elongation(mean, p), 1.0)


def watching(camera: Camera, p: Record) -> Number:
    """1 where the camera has told an elongation not long ago, else 0."""
    return where(camera.age < p.camera_timeout, camera.said, 0.0)


def doubtful(camera: Camera, belief: Belief, u: Record, p: Record) -> Number:
    """1 where the camera says it is well and yet is not followed, else 0."""
    by_temperature = model.elongation(belief.mean, p)
    bound = _AT_BOUND * authority(by_temperature, p)
    held_back = where(absolute(added_by_camera(belief.mean, by_temperature)) > bound, 1.0, camera.out)
    silent = where(camera.age > p.camera_timeout, 1.0, 1.0 - fail_safe.present(u.measured_drift))
    return maximum(held_back, where(u.drift_valid > 0.5, silent, 0.0))


def _named(camera: Camera) -> dict[str, Number]:
    return {f"camera_{name}": value for name, value in camera._asdict().items()}
