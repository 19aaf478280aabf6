"""An FMU or a system from any tool, checked as its user would check it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.fmus.arguments import argument, path_given
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import listed
from warmlink.orchestration.check.fmu import TIME_LIMIT, CheckResult, check_fmu, validity_problems
from warmlink.orchestration.console import Answer
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.progress import Progress, spinner
from warmlink.orchestration.shell import command
from warmlink.orchestration.simulation import simulate
from warmlink.orchestration.system.assemble import read_system, refuse_variant, variants
from warmlink.orchestration.text_files import is_folder
from warmlink.orchestration.written.quantities import positive

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, repr=False)
class Checked(Answer):
    """What the checks of a file found."""

    name: str
    results: Sequence[CheckResult]

    @property
    def failed(self) -> bool:
        """Whether a check found a fault."""
        return any(each.verdict == "fail" for each in self.results)

    def summary(self) -> str:
        """A line for each check."""
        lines = (f"{each.verdict:<7} {each.name}  {each.detail}".rstrip() for each in self.results)
        return "\n".join([self.name, *lines])

    def to_frame(self) -> pandas.DataFrame:
        """A row for each check."""
        import pandas

        return pandas.DataFrame(self.to_dict())

    def to_dict(self) -> list[dict[str, Any]]:
        """The same for JSON."""
        return [asdict(each) for each in self.results]


def check(file: str | Path, *, variant: str | None = None, time_limit: str | float = TIME_LIMIT) -> Checked:
    """Check an FMU or a system from any tool as its user would check it.

    Parameters
    ----------
    file : an .fmu or .ssp file
    variant : which system, of several in one SSP, by default `SystemStructure`
    time_limit : longest time that one check of an FMU may take, `"30 s"` or in s

    Raises
    ------
    InputError
        If the file cannot be read, or is a folder, or there is no such variant.

    Examples
    --------
    >>> print(wl.check("dist/native/fmi2/ThermalLink.fmu"))
    """
    path, limit = path_given("file", file), positive(time_limit, "s", argument("time_limit"))
    if is_folder(path):
        raise InputError(_folder(path))
    with spinner(f"Checking {path.name}") as progress:
        if path.suffix == ".ssp":
            found = _check_system(path, variant, progress)
        else:
            refuse_variant(path, variant)
            found = check_fmu(path, limit, progress=progress)
    return Checked(str(path), found)


_NAMED = 5
"""Files of a folder, at most, that a sentence names."""


def _folder(folder: Path) -> str:
    """Say what a folder holds that can be checked."""
    if (folder / "modelDescription.xml").is_file():
        return f"{folder}: is an unpacked FMU; pack it into a zip archive named .fmu"
    files = sorted(path for kind in ("fmu", "ssp") for path in folder.rglob(f"*.{kind}"))
    if not files:
        return f"{folder}: is a folder without .fmu or .ssp files; give the path of one"
    names = ", ".join(str(path.relative_to(folder)) for path in files[:_NAMED])
    more = f" and {len(files) - _NAMED} more" if len(files) > _NAMED else ""
    one = command("warmlink", "check", files[0])
    return f"{folder}: is a folder, which holds {names}{more}; check one of them: {one}"


def _check_system(path: Path, variant: str | None, progress: Progress) -> list[CheckResult]:
    """Check a system: that it reads, that each FMU is valid, and that it runs its default experiment."""
    with temporary_folder() as work:
        system = read_system(path, work, variant)
        detail = f"{len(system.components)} components, {len(system.connections)} connections"
        named = variants(path)
        if len(named) > 1:
            detail += f"; variants: {listed(named)}"
        results = [CheckResult("reads and fits together", "pass", detail)]
        for k, (name, held) in enumerate(system.components.items()):
            progress(f"{name} is valid", k / (1 + len(system.components)))
            found = "; ".join(validity_problems(held.fmu))[:200]
            results.append(CheckResult(f"{name} is valid", "fail" if found else "pass", found))
        stop = system.default_experiment.stop_time
        if stop is None:
            return [*results, CheckResult("runs", "skip", "the system proposes no stop time")]
        try:
            run = simulate(system)
        except SlaveError as fault:
            return [*results, CheckResult("runs", "fail", str(fault))]
    done = "; ".join((f"{stop:g} s in steps of {run.table.points.step_size:g} s", *run.remarks))
    return [*results, CheckResult("runs", "fail" if run.stopped else "pass", run.stopped or done)]
