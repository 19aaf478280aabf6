"""The drift camera's noise: images of a laser spot on a CCD, and their centroid by image moments.

[1] II.A.1: no lens, cells of 8.6 x 8.3 um, 752 x 582 of them, gamma 0.45, black and white level, electronic
shutter; the centroid is the sum of the pixel moments in two orthogonal directions. What [1] does not give
(the spot's size and brightness, the electrons at full level and the read-out noise, the frame grabber's bits,
the threshold) is estimated or assumed, and marked so. Left out: the interlaced field mode, which halves the
resolution across the drift only, and the jitter of the frame grabber's clock from line to line, unknown here.

[1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill, "Temperature-Induced Deformation in a Mechanical System".
[2] PULNiX, TM-2016-8 data sheet, "Dynamic Range Control": a later interline camera of the same maker, and
what an ordinary video camera makes of such a chip.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf
from scipy.stats import norm

from benchmarks.command import start
from warmlink.fmus.errors import InputError
from warmlink.orchestration.paper.data import PAPER

Array = NDArray[np.float64]
Image = NDArray[np.int64]

#: [2]: a well holds 50 000 electrons and saturates at 400 to 500 mV; estimated to be so here too.
WELL, SATURATION = 5.0e4, 0.45
#: [2]: the video's full level [V], reached with a gain of 16 to 22 dB, 20 in its own example.
VIDEO, GAIN = 0.714, 20.0
#: Electrons that noise adds on such a chip at room temperature, [2]; it is 20 to 50 on others of the maker.
READ_NOISE = 40.0
#: The laser is made as bright as the frame grabber shows without saturating: the peak's share of its range.
PEAK = 0.9


def electrons_at_white(gain: float = GAIN) -> float:
    """Electrons in a cell that reach the white level with a gain [dB]; less than a fifth of the well, [2]."""
    return WELL * VIDEO / 10 ** (gain / 20) / SATURATION


@dataclass(frozen=True)
class Camera:
    """A CCD camera with its frame grabber; what [1] does not give has a default.

    `cell_width`, `cell_height` [m]; `columns`, `rows`; `gamma`, output = input^gamma; `black_level`,
    `white_level` [V]; `shutter` [s]; `full_level`, which reaches the white level, and `read_noise`
    [electrons]; `bits` of the frame grabber, whose range runs from 0 V to the white level.
    """

    cell_width: float
    cell_height: float
    columns: int
    rows: int
    gamma: float
    black_level: float
    white_level: float
    shutter: float
    full_level: float = field(default_factory=electrons_at_white)  # estimated
    read_noise: float = READ_NOISE  # estimated
    bits: int = 8  # assumed

    @classmethod
    def printed(cls) -> Camera:
        """Read the camera's figures from the paper's numbers."""
        n = {name: entry.value for name, entry in PAPER["camera"].items()}
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

    def rate_for(self, share: float) -> float:
        """Electrons a second that bring a cell to a share of the frame grabber's range."""
        dark = self.black_level / self.white_level
        filled = ((share - dark) / (1 - dark)) ** (1 / self.gamma)
        return self.full_level * filled / self.shutter


@dataclass(frozen=True)
class Spot:
    """A Gaussian spot: centre `x`, `y` [m] from the chip's corner, `rate` [electrons/s], 1/e^2 `radius` [m].

    `rate` is that of a cell at the centre. The default radius spans seven cells; it is assumed, and matters
    little: a wider spot is told less sharply by more light.
    """

    x: float
    y: float
    rate: float
    radius: float = 60e-6


def tuned_spot(camera: Camera) -> Spot:
    """A spot amid the chip, its laser tuned to the camera's shutter so that nothing saturates.

    The camera's laser was "almost invisible" ([1] II.A.1), as it has to be straight on a chip.
    """
    x, y = camera.columns / 2 * camera.cell_width, camera.rows / 2 * camera.cell_height
    return Spot(x, y, camera.rate_for(PEAK))


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
    filled = np.clip(electrons / camera.full_level, 0.0, 1.0)
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


def noise_threshold(camera: Camera, false_images: float = 0.01) -> float:
    """Threshold [counts] that read-out noise in the dark exceeds anywhere in only so few images.

    One dark cell far from the spot has a long lever in the moments, so none may count. The gamma curve is
    steepest in the dark and lifts that noise most. Give the whole chip, whatever window is read out.
    """
    sigmas = norm.isf(false_images / (camera.columns * camera.rows))
    dark = sigmas * camera.read_noise / camera.full_level
    return float((2**camera.bits - 1 - camera.black) * dark**camera.gamma)


def drift_noise(chip: Camera | None = None, images: int = 1000) -> CentroidError:
    """Error of a drift reading of the tuned spot, from so many images; the DriftCamera's noise is this.

    A window around the spot is exposed; the threshold keeps everything farther out away.
    """
    chip = chip or Camera.printed()
    camera = chip.window(96, 96)
    return characterise(camera, tuned_spot(camera), noise_threshold(chip), images=images)


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


def _cell_shares(centre: float, radius: float, size: float, count: int) -> Array:
    """Mean of exp(-2 (x - centre)^2 / radius^2) over each cell of a row."""
    edges = (np.arange(count + 1) * size - centre) * np.sqrt(2) / radius
    return np.asarray(np.sqrt(np.pi / 8) * radius / size * np.diff(erf(edges)))


def main() -> None:
    """Print the centroid's error by the defaults, and at both ends of the ranges in the data sheet [2]."""
    chip = Camera.printed()
    for gain, noise in ((16.0, 20.0), (GAIN, READ_NOISE), (22.0, 50.0)):
        found = drift_noise(replace(chip, full_level=electrons_at_white(gain), read_noise=noise))
        print(
            f"gain {gain:g} dB, read-out noise {noise:g} electrons: {found.total:.4f} pixel, "
            f"{1e6 * found.total * chip.cell_width:.3f} um; bias {found.bias:.4f}, at most "
            f"{found.largest:.4f} pixel"
        )


if __name__ == "__main__":
    start(main)
