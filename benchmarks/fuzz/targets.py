"""What is damaged, and who has to take or refuse it."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random

from benchmarks.fuzz import kept
from benchmarks.fuzz.mutate import (
    Mutator,
    csv_cells,
    flipped,
    huge_units,
    lines,
    quoted,
    spliced,
    swapping,
    toml_values,
    word_columns,
    words,
    xml_values,
)
from warmlink.fmus.errors import MOST_SENTENCES, InputError, SeveralError
from warmlink.fmus.recorded_duty.component import COMPONENT as PLAYER
from warmlink.fmus.recorded_duty.component import duty_table, playing
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.diagnosis.arm.measured import arm_experiments
from warmlink.orchestration.diagnosis.data.experiment import read_experiment
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.guard import guarded
from warmlink.orchestration.master.run import simulate
from warmlink.orchestration.master.slaves.slave import SlaveError
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.overrides import parameters_of, start_values
from warmlink.orchestration.studies.study import load_study
from warmlink.orchestration.system.assemble import read_system
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import FmuPart, System

SPECIMENS = Path(__file__).parent / "specimens"
LONGEST_SENTENCE = 1200
LINK = "ThermalLink"
DESCRIPTION = "modelDescription.xml"

Files = Mapping[str, bytes]


@dataclass(frozen=True)
class Target:
    """A reader and what is put before it.

    Attributes
    ----------
    files : gives the good files, of which one is damaged at a time
    mutators : ways of damaging one, chosen at random
    use : reads the damaged file, given its path; the other files lie beside it
    damaged : names of the files that are damaged; all where empty
    share : of the usual number of inputs, for readers that take long
    """

    files: Callable[[], Files]
    mutators: tuple[Mutator, ...]
    use: Callable[[Path], object]
    damaged: tuple[str, ...] = ()
    share: float = 1.0

    def written(self, random: Random, folder: Path) -> Path:
        """Write the files into a folder, one of them damaged; give its path."""
        files = self.files()
        name = random.choice(self.damaged or tuple(files))
        for other, content in files.items():
            (folder / other).write_bytes(content)
        (folder / name).write_bytes(random.choice(self.mutators)(random, files[name]))
        return folder / name

    def judged(self, path: Path) -> str:
        """Read a file: `accepted`, `refused`, or what is wrong with how it went."""
        try:
            self.use(path)
        except SeveralError as refusal:
            return _sentences(str(refusal).split("\n"))
        except (InputError, SlaveError) as refusal:
            return _sentence(str(refusal))
        except AssertionError as fault:
            return f"wrong: {fault}"
        except Exception as fault:  # the very thing that is looked for
            return f"{type(fault).__name__}: {fault}"[:300]
        return "accepted"


def _sentences(told: list[str]) -> str:
    """What is wrong with the lines of which each says a mistake; the last may say how many more there are."""
    if len(told) > MOST_SENTENCES + 1:
        return f"{len(told)} lines: {told[:3]}"
    shown = told[:-1] if told[-1].endswith(" more") else told
    return next((verdict for each in shown if (verdict := _sentence(each)) != "refused"), "refused")


def _sentence(told: str) -> str:
    if len(told.splitlines()) != 1 or "Traceback" in told:
        return f"not one line: {told[:300]!r}"
    if not 10 < len(told) <= LONGEST_SENTENCE:
        return f"{len(told)} characters: {told[:300]!r}"
    return "refused"


def _specimens(*names: str) -> Callable[[], Files]:
    return cache(lambda: {name: (SPECIMENS / name).read_bytes() for name in names})


def packed(entries: Files) -> bytes:
    """Give a zip archive, the same bytes each time."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in entries.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    return stream.getvalue()


def _system_of(structure: bytes) -> bytes:
    fmus = {
        name: packed({DESCRIPTION: (SPECIMENS / f"{name}.xml").read_bytes()}) for name in ("Link", "Motor")
    }
    return packed(
        {"SystemStructure.ssd": structure, **{f"resources/{name}.fmu": fmu for name, fmu in fmus.items()}}
    )


@cache
def _cell() -> Files:
    return {"cell.ssp": _system_of((SPECIMENS / "cell.ssd").read_bytes())}


@cache
def _link() -> Files:
    fmu = FmuStore("native").files([LINK])[LINK]
    with zipfile.ZipFile(fmu) as archive:
        entries = {name: archive.read(name) for name in archive.namelist() if not name.startswith("sources/")}
    return {DESCRIPTION: entries.pop(DESCRIPTION), "rest.zip": packed(entries)}


def _read_structure(path: Path) -> None:
    whole = path.with_suffix(".ssp")
    whole.write_bytes(_system_of(path.read_bytes()))
    read_system(whole, path.parent / "work")


def _read_model(path: Path) -> None:
    fmu = path.with_suffix(".fmu")
    fmu.write_bytes(packed({DESCRIPTION: path.read_bytes()}))
    read_description(fmu)


def _run_model(path: Path) -> None:
    """Run an FMU whose binary is sound and whose description is not."""
    with zipfile.ZipFile(path.with_name("rest.zip")) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    fmu = path.with_name("Link.fmu")
    fmu.write_bytes(packed({DESCRIPTION: path.read_bytes(), **entries}))
    found = System("s", {"link": FmuPart("link", fmu)}, ())
    unpacked = path.parent / "work"
    guarded(lambda line: simulate(found, 3.0, 1.0, unpacked=unpacked, stepping="plain", line=line))


PLAYED = playing(
    PLAYER, duty_table([0.0, 5.0, 9.0], {"speed": [1.0, 2.0, 3.0], "pad_mode": [0, 2, 1]}, ["speed"])
).tables[0]
"""A table of three rows, of the file that RecordedDuty plays."""


def _sealed(random: Random, content: bytes) -> bytes:
    """Damage a table whose checksum is right all the same."""
    damaged = flipped(random, content[:-8])
    return damaged + zlib.crc32(damaged).to_bytes(8, "little")


def _set_up(path: Path) -> None:
    load_scenario(str(path)).values()


def _parameters(path: Path) -> None:
    law = catalogue.controller("lag")
    start_values(parameters_of(path), WARMUP_CELL.declared(law), path.name)


def _mismatched(path: Path) -> None:
    load_scenario("windshield_wiper").mismatched(mismatch.load(str(path))).values()


swapped = swapping(_specimens(*sorted(path.name for path in SPECIMENS.iterdir())))
ANY = (spliced, lines, words, huge_units, swapped)
"""What is done to a text of any kind."""

XML, TOML, CSV = (
    (*ANY, xml_values),
    (*ANY, toml_values),
    (*ANY, csv_cells, flipped, quoted, word_columns),
)

TARGETS: dict[str, Target] = {
    "ssp": Target(_cell, (flipped, swapped), lambda path: read_system(path, path.parent / "work")),
    "ssd": Target(_specimens("cell.ssd"), XML, _read_structure),
    "ssv": Target(_specimens("parameters.ssv"), XML, _parameters),
    "description": Target(_specimens("Link.xml", "Motor.xml", "fmi3.xml"), (*XML, flipped), _read_model),
    "wrong description": Target(_link, XML, _run_model, (DESCRIPTION,), share=0.02),
    "scenario": Target(_specimens("scenario.toml", "duty.toml", "random.toml"), TOML, _set_up),
    "study": Target(_specimens("study.toml"), TOML, lambda path: load_study(str(path))),
    "mismatch": Target(_specimens("mismatch.toml"), TOML, _mismatched),
    "program": Target(_specimens("program.toml", "jobs.toml"), TOML, _set_up, share=0.5),
    "experiment": Target(
        _specimens("experiment.toml", "rod.csv"), TOML, read_experiment, ("experiment.toml",)
    ),
    "table": Target(
        cache(lambda: {PLAYED.file: PLAYED.content}),
        (flipped, _sealed),
        lambda path: PLAYED.read(path.read_bytes(), path.name),
    ),
    "duty": Target(_specimens("duty.csv"), CSV, _set_up),
    "measured": Target(_specimens("measured.csv"), CSV, read_experiment),
    "measured arm": Target(_specimens("arm.csv"), CSV, arm_experiments, share=0.2),
    "checkpoint": Target(
        kept.run_until_killed, (flipped, swapped), kept.resume, (kept.CHECKPOINT, kept.RESULTS), share=0.2
    ),
    "stamped checkpoint": Target(
        kept.run_until_killed, (kept.stamped_checkpoint,), kept.resume_stamped, (kept.CHECKPOINT,), share=0.2
    ),
    "state": Target(kept.state, (flipped, swapped, kept.stamped_state), kept.take_state),
    "runs": Target(kept.finished_runs, (flipped, lines, spliced, swapped, words), kept.read_ledger),
}
