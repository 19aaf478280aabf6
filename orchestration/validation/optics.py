"""The optical measurement: a laser spot straight on a CCD, and its centroid by image moments.

[1] II.A.1: no lens, cells of 8.6 x 8.3 um, 752 x 582 of them, gamma 0.45, black and white level, electronic
shutter; the centroid is the sum of the pixel moments in two orthogonal directions. What [1] does not give
(the spot's size and brightness, the cells' capacity and read-out noise, the frame grabber's bits, the
threshold) is assumed, and marked so. The interlaced field mode is left out: it halves the resolution across
the drift only.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from warmlink.fmus.errors import InputError
from warmlink.orchestration.validation.data import load_paper

Array = NDArray[np.float64]
Image = NDArray[np.int64]


@dataclass(frozen=True)
class Camera:
    """A CCD camera with its frame grabber; defaults that [1] does not give are marked as assumed.

    `cell_width`, `cell_height` [m]; `columns`, `rows`; `gamma`, output = input^gamma; `black_level`,
    `white_level` [V]; `shutter` [s]; `full_well` and `read_noise` [electrons]; `bits` of the frame grabber,
    whose range runs from 0 V to the white level.
    """

    cell_width: float
    cell_height: float
    columns: int
    rows: int
    gamma: float
    black_level: float
    white_level: float
    shutter: float
    full_well: float = 3.0e4  # assumed
    read_noise: float = 30.0  # assumed
    bits: int = 8  # assumed

    @classmethod
    def printed(cls) -> Camera:
        """Read the camera's figures from the paper's numbers."""
        n = {name: entry.value for name, entry in load_paper()["camera"].items()}
        return cls(
            cell_width=n["cell_horizontal"] * 1e-6,
            cell_height=n["cell_vertical"] * 1e-6,
            columns=int(n["pixels_horizontal"]),
            rows=int(n["pixels_vertical"]),
            gamma=n["gamma"],
            black_level=n["black_level"] * 1e-3,
            white_level=n["white_level"] * 1e-3,
            shutter=n["shutter"],
        )

    def window(self, columns: int, rows: int) -> Camera:
        """Return a camera that reads out only so many cells."""
        return replace(self, columns=columns, rows=rows)

    @property
    def black(self) -> float:
        """Count of the frame grabber that the black level gives."""
        return (2**self.bits - 1) * self.black_level / self.white_level


@dataclass(frozen=True)
class Spot:
    """A Gaussian spot: centre `x`, `y` [m] from the chip's corner, 1/e^2 `radius` [m], `rate` [electrons/s].

    `rate` is that of a cell at the centre. The default radius spans seven cells; the default rate fills less
    than a tenth of a cell in 1/10000 s, the laser being "almost invisible". Both are assumed, the rate chosen
    so that the centroid errs by the 0.02 cells of the DriftCamera component: the images show which brightness
    that figure stands for, they do not confirm it.
    """

    x: float
    y: float
    radius: float = 60e-6
    rate: float = 2.4e7


@dataclass(frozen=True)
class CentroidError:
    """Error of the centroid along the rows, in cells: sub-pixel `bias` (rms), `largest` bias, and `noise`."""

    bias: float
    largest: float
    noise: float

    @property
    def total(self) -> float:
        """Standard deviation [cells] of a centroid whose place within its cell is random."""
        return float(np.hypot(self.bias, self.noise))


def expose(camera: Camera, spot: Spot, rng: np.random.Generator | None = None) -> Image:
    """Take an image of the spot.

    Parameters
    ----------
    camera : chip and frame grabber
    spot : what falls on it
    rng : source of shot and read-out noise; None takes none

    Returns
    -------
    counts of shape (rows, columns)
    """
    across = _cell_shares(spot.x, spot.radius, camera.cell_width, camera.columns)
    down = _cell_shares(spot.y, spot.radius, camera.cell_height, camera.rows)
    electrons = spot.rate * camera.shutter * np.outer(down, across)
    if rng is not None:
        electrons = rng.poisson(electrons) + rng.normal(0.0, camera.read_noise, electrons.shape)
    filled = np.clip(electrons / camera.full_well, 0.0, 1.0)
    volts = camera.black_level + (camera.white_level - camera.black_level) * filled**camera.gamma
    counts = np.rint((2**camera.bits - 1) * volts / camera.white_level)
    return np.asarray(counts, dtype=np.int64)


def centroid(image: Image, camera: Camera, threshold: float) -> tuple[float, float]:
    """Centroid of the spot by its zeroth and first moments in both directions.

    Parameters
    ----------
    image : counts of shape (rows, columns)
    camera : gives the size of the cells and the black level
    threshold : counts above the black level from which a cell belongs to the spot; it weighs by what is
        above the threshold

    Returns
    -------
    x and y [m] from the chip's corner

    Raises
    ------
    InputError
        No cell reaches the threshold.
    """
    weight = np.clip(image - camera.black - threshold, 0.0, None)
    mass = weight.sum()
    if mass <= 0:
        raise InputError(
            f"image: no cell is {threshold:g} counts above black; lower the threshold or add light"
        )
    columns, rows = np.arange(image.shape[1]) + 0.5, np.arange(image.shape[0]) + 0.5
    x, y = weight.sum(axis=0) @ columns / mass, weight.sum(axis=1) @ rows / mass
    return float(x * camera.cell_width), float(y * camera.cell_height)


def noise_threshold(camera: Camera, sigmas: float = 4.0) -> float:
    """Threshold [counts] that read-out noise in the dark exceeds as rarely as a normal number `sigmas`.

    The gamma curve is steepest in the dark and lifts that noise most.
    """
    dark = sigmas * camera.read_noise / camera.full_well
    return float((2**camera.bits - 1 - camera.black) * dark**camera.gamma)


def drift_noise(camera: Camera | None = None) -> float:
    """Standard deviation [m] of a drift reading of the default spot, bias within the cell included."""
    camera = camera or Camera.printed().window(96, 96)
    middle = Spot(camera.columns / 2 * camera.cell_width, camera.rows / 2 * camera.cell_height)
    return characterise(camera, middle, noise_threshold(camera)).total * camera.cell_width


def characterise(
    camera: Camera, spot: Spot, threshold: float, *, places: int = 40, images: int = 200, seed: int = 1
) -> CentroidError:
    """Measure bias and noise of the centroid along the rows.

    Parameters
    ----------
    camera, spot, threshold : as for `expose` and `centroid`; the spot is moved from where it is
    places : positions across one cell at which the bias is measured, without noise
    images : noisy images, at random places within the cell, from which the noise is measured
    seed : of the noise and of the places
    """
    rng = np.random.default_rng(seed)

    def error(offset: float, source: np.random.Generator | None) -> float:
        moved = replace(spot, x=spot.x + offset * camera.cell_width)
        x, _ = centroid(expose(camera, moved, source), camera, threshold)
        return (x - moved.x) / camera.cell_width

    biases = np.array([error(i / places, None) for i in range(places)])
    offsets = rng.random(images)
    noisy = np.array([error(o, rng) - error(o, None) for o in offsets])
    bias = biases - biases.mean()
    return CentroidError(float(bias.std()), float(np.abs(bias).max()), float(noisy.std(ddof=1)))


def measured_drift(
    camera: Camera, start: Spot, elongation: Array, threshold: float, rng: np.random.Generator | None
) -> Array:
    """Drift [m] read off a sequence of images while the link grows, relative to the first image.

    Parameters
    ----------
    elongation : true growth at each image [m], shape (n,); the spot moves by as much along the rows
    start : the spot before any growth
    """
    places = [
        centroid(expose(camera, replace(start, x=start.x + float(growth)), rng), camera, threshold)[0]
        for growth in elongation
    ]
    return np.asarray(places) - places[0]


def _cell_shares(centre: float, radius: float, size: float, count: int) -> Array:
    """Mean of exp(-2 (x - centre)^2 / radius^2) over each cell of a row."""
    edges = (np.arange(count + 1) * size - centre) * np.sqrt(2) / radius
    return np.asarray(np.sqrt(np.pi / 8) * radius / size * np.diff(erf(edges)))
