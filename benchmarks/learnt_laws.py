"""Laws on machines of other structure, learnt from a training log or as they ship, judged on other logs.

Beside them stands a ridge of five lines on base and tip. Logs are those of the bench's own machines, or of a
folder with files NAME_training.parquet and NAME_WHAT.parquet.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks import strange_machine
from benchmarks.command import start
from warmlink.orchestration.replay.compare import FIGURES, Replayed, replayed

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

LAWS = "regression,observer,observer_drift"

TOLERANCE_UM, SETTLING_S = 5.0, 120.0


def ridge(training: pd.DataFrame, log: pd.DataFrame) -> Array:
    """Growth in um by five lines: a ridge on base and tip after a low-pass of 30 s."""

    def seen(frame: pd.DataFrame) -> Array:
        share, columns = -np.expm1(-1 / 30), [f"{place}_temperature [degC]" for place in ("base", "tip")]
        values = frame[columns].to_numpy()
        return np.asarray(lfilter([share], [1, share - 1], values, axis=0, zi=(1 - share) * values[:1])[0])

    known = training["elongation [um]"].notna().to_numpy()
    x, y = seen(training)[known], training["elongation [um]"].to_numpy()[known]
    mean, spread = x.mean(axis=0), x.std(axis=0)
    z = (x - mean) / spread
    c = np.linalg.solve(z.T @ z + 1e-3 * len(z) * np.eye(2), z.T @ (y - y.mean()))
    return np.asarray((seen(log) - mean) / spread @ c + y.mean())


def ridge_figures(training: pd.DataFrame, log: pd.DataFrame) -> dict[str, float]:
    """Figures of the ridge on a log, as far as it has them."""
    growth = log["growth [um]"].to_numpy()
    late = log["time [s]"].to_numpy() > SETTLING_S
    error = (growth - ridge(training, log))[late]
    worst = float(np.abs(error).max())
    return {
        "removed_percent": 100 * (1 - worst / float(np.abs(growth).max())),
        "rms_um": float(np.sqrt(np.mean(error**2))),
        "worst_um": worst,
        "outside_percent": 100 * float(np.mean(np.abs(error) > TOLERANCE_UM)),
    }


def machines(folder: Path | None, seeds: list[int]) -> Iterator[tuple[str, dict[str, pd.DataFrame]]]:
    """Logs of each machine by name, `training` among them."""
    if folder is None:
        for seed in seeds:
            yield f"seed {seed}", dict(strange_machine.logs(seed))
        return
    import pandas as pd

    for training in sorted(folder.glob("*_training.parquet")):
        name = training.stem.removesuffix("_training")
        yield name, {f.stem[len(name) + 1 :]: pd.read_parquet(f) for f in sorted(folder.glob(f"{name}_*"))}


def main(
    logs: Annotated[Path | None, typer.Option(help="Folder of logs in place of the bench's own.")] = None,
    seeds: Annotated[str, typer.Option(help="Machines of the bench, by their seeds.")] = "1,2,3",
    minutes: Annotated[float, typer.Option(help="Minutes of the training log; 0: all.")] = 0.0,
    laws: Annotated[str, typer.Option(help="Controllers.")] = LAWS,
    shipped: Annotated[bool, typer.Option(help="Laws as they ship: they learn nothing.")] = False,
) -> None:
    """Print the figures of each law over all logs of all machines."""
    found: defaultdict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for name, runs in machines(logs, [int(seed) for seed in seeds.split(",")]):
        training = runs.pop("training")
        training = training[training["time [s]"] <= 60 * minutes] if minutes else training
        learn = [] if shipped else [training]
        result = replayed(list(runs.values()), laws.split(","), learn=learn)
        for law in result.controllers:
            for log in result.logs:
                for figure in FIGURES:
                    found[law][figure].append(getattr(result.rows[law, log], figure))
        for run in runs.values():
            for figure, value in ridge_figures(training, run).items():
                found["ridge of five lines"][figure].append(value)
        print(f"{name}\n{summary(result)}")
    print("all machines\n" + "".join(f"{_line(law, of)}\n" for law, of in found.items()), end="")


def summary(result: Replayed) -> str:
    """A line for each law."""
    return "\n".join(
        _line(law, {n: [getattr(result.rows[law, log], n) for log in result.logs] for n in FIGURES})
        for law in result.controllers
    )


def _line(law: str, of: dict[str, list[float]]) -> str:
    figures = "  ".join(f"{name} {FIGURES[name](values):.2f}" for name, values in of.items())
    return f"  {law:20s} {figures}"


if __name__ == "__main__":
    start(main)
