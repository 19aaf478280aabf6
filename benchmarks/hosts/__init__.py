"""Masters to be timed, ours and other people's: each runs one job in a process of its own."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata


@dataclass(frozen=True)
class Job:
    """What a master is to run: the same for all.

    Attributes
    ----------
    ssp : path of the system
    steps : communication steps
    step_size : in s
    watched : output whose last value is asked for, as `link.elongation`
    reference : its value reference
    """

    ssp: str
    steps: int
    step_size: float
    watched: str
    reference: int

    @property
    def stop_time(self) -> float:
        """In s."""
        return self.steps * self.step_size

    @property
    def instance(self) -> str:
        """Slave whose output is watched."""
        return self.watched.rpartition(".")[0]

    @property
    def variable(self) -> str:
        """The output's own name."""
        return self.watched.rpartition(".")[2]


@dataclass(frozen=True)
class Finished:
    """A job done: wall time of a communication step in µs, and the last value of the watched output."""

    step_us: float
    value: float


@dataclass(frozen=True)
class Host:
    """A master that can be timed.

    Attributes
    ----------
    name : as it stands in the table
    function : `module:function` below this package; takes a Job, gives a Finished
    packages : distributions it needs
    iterates : whether it repeats steps, which costs time for accuracy
    """

    name: str
    function: str
    packages: tuple[str, ...] = ()
    iterates: bool = False

    @property
    def missing(self) -> tuple[str, ...]:
        """Distributions that are not installed."""
        return tuple(package for package in self.packages if not _installed(package))


HOSTS = (
    Host("warmlink, plain", "ours:plain"),
    Host("warmlink, compiled", "ours:compiled"),
    Host("warmlink, fixed_point", "ours:iterated", iterates=True),
    Host("FMPy, plain loop", "fmpy_loop:run"),
    Host("libcosim", "libcosim:run", ("libcosimpy",)),
    Host("Ecos", "ecos:run", ("ecospy", "tbb")),
)


def _installed(package: str) -> bool:
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        return False
    return True
