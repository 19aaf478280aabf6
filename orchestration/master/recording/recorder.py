"""What is kept of a run, and where: in memory, or in a file that is valid at every moment."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.files import fresh_file, whole_file, write_all
from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.result import RecordTable
from warmlink.orchestration.master.slaves import under_way
from warmlink.orchestration.master.slaves.network import Network
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.system.description import FmuVariable

VALUES, COLUMNS = "values.npy", "columns.json"
BLOCK_ROWS = 4096
MOST_BYTES = 2e9


class StoreError(Exception):
    """Values can no longer be written; the run ends there, and what was written before is kept."""

    def __init__(self, path: Path, fault: OSError) -> None:
        super().__init__(f"{path.name} cannot be written any more ({fault.strerror})")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the disk does not take into a StoreError."""
    try:
        yield
    except OSError as fault:
        raise StoreError(path, fault) from None


class Values:
    """Writes `values.npy` and `columns.json` into a folder, block by block.

    The header of `values.npy` counts the rows that were written before it was, so that the file can be read
    whenever the run ends, be it by a kill. An interrupted run may have left rows there that its checkpoint
    counts on: so many are kept, and they must have the digest.
    """

    def __init__(self, folder: Path, *, keep: int = 0, digest: str = "") -> None:
        self.folder = folder
        self.path = folder / VALUES
        self._keep, self._expected = keep, digest
        self._digest = hashlib.sha256()
        self._file: BinaryIO
        self._columns = 0

    def open(self, header: RecordTable) -> None:
        """Begin to write; InputError where the folder cannot be written or lacks rows to keep."""
        points, columns = (
            header.points,
            [
                {
                    "name": n,
                    "unit": header.units[n],
                    **({"type": header.types[n]} if n in header.types else {}),
                }
                for n in header.names
            ],
        )
        about = {"columns": columns, "start_time_s": points.start_time, "step_size_s": points.step_size}
        about["steps"] = points.count
        if points.uneven:
            about["times_s"] = points.uneven
        self._columns = len(columns)
        if self._keep:
            self._check()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with fresh_file(self.folder / COLUMNS) as scratch:
                scratch.write_text(json.dumps(about, indent=1), encoding="utf-8")
                if not self._keep:  # those of a run before go now that these can be written
                    with whole_file(self.path) as begun:
                        begun.write_bytes(self._npy_header(0))
            # Without a buffer, which would try to write again on closing what the disk did not take.
            self._file = self.path.open("r+b", buffering=0)
        except OSError as fault:
            told = f"{self.folder}: cannot be written ({fault.strerror}); choose another folder"
            raise InputError(told) from None

    def _check(self) -> None:
        """Refuse values that are not those which the checkpoint counts on."""
        begin, end = self._place(0), self._place(self._keep)
        anew = f"leave out {argument('long_run.resume')} to start anew"
        if not self.path.exists() or self.path.stat().st_size < end:
            told = f"lacks values that the checkpoint beside it counts on; {anew}"
            raise InputError(f"{self.path}: {told}")
        self._digest.update(np.memmap(self.path, np.uint8, "r", begin, (end - begin,)).data)
        if self._digest.hexdigest() != self._expected:
            told = f"is damaged, its values are not those that the checkpoint beside it counts on; {anew}"
            raise InputError(f"{self.path}: {told}")

    def put(self, first: int, rows: Array) -> None:
        """Write rows to their place, then count them; StoreError where the disk does not take them."""
        data = np.ascontiguousarray(rows, dtype="<f8").tobytes()
        with writing(self.path):
            self._file.seek(self._place(first))
            write_all(self._file, data)
            self._file.seek(0)
            write_all(self._file, self._npy_header(first + len(rows)))
        self._digest.update(data)

    def secure(self) -> str:
        """Have everything written reach the disk; give its digest."""
        with writing(self.path):
            os.fsync(self._file.fileno())
        return self._digest.hexdigest()

    def values(self, first: int, rest: Array) -> Array:
        """Write the last rows, as far as the disk takes them, and map the file."""
        with suppress(StoreError, OSError):
            self.put(first, rest)
            self._file.truncate(self._place(first + len(rest)))
        self._file.close()
        # An array without rows or columns cannot be mapped.
        found: Array = np.load(self.path, mmap_mode=None if self.path.stat().st_size <= 128 else "r")
        return found

    def _place(self, row: int) -> int:
        """Give where a row begins in the file."""
        return len(self._npy_header(0)) + row * 8 * self._columns

    def _npy_header(self, rows: int) -> bytes:
        """Give NumPy's header, which is of one length whatever the number of rows."""
        stream, shape = BytesIO(), (rows, self._columns)
        np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
        return stream.getvalue()


def values_in(folder: Path) -> RecordTable | None:
    """What a run wrote to a folder while it ran; None if there is none, or it cannot be read."""
    with suppress(OSError, ValueError, LookupError, TypeError):
        about = json.loads((folder / COLUMNS).read_text("utf-8"))
        names = tuple(str(each["name"]) for each in about["columns"])
        start, step, count = float(about["start_time_s"]), float(about["step_size_s"]), int(about["steps"])
        values = np.load(folder / VALUES, mmap_mode=None)
        if values.ndim == 2 and values.shape[1] == len(names) and len(values) <= count + 1:
            units = {each["name"]: each["unit"] for each in about["columns"]}
            points = CommunicationPoints.between(start, start + count * step, step)
            if "times_s" in about:
                times = [float(each) for each in about["times_s"]]
                points = CommunicationPoints.at(times, start, times[-1])
            types = {each["name"]: str(each["type"]) for each in about["columns"] if "type" in each}
            return RecordTable(names, units, points, values, types)
    return None


WHOLE = {"Int64": "int64", "UInt64": "uint64"}
"""Types of FMI whose values a double may not hold, and NumPy's names of them."""


def is_number(variable: FmuVariable) -> bool:
    """Tell whether a variable is a scalar number, which alone is recorded."""
    return variable.kind not in (None, "String", "Binary") and not variable.dimensions


def is_recorded(variable: FmuVariable) -> bool:
    """Tell whether a variable is recorded unasked."""
    return variable.causality == "output" and is_number(variable)


class Recorder:
    """Values in rows of a preallocated block, one for each communication point, in the variables' own units.

    Outputs that the network reads are kept as they were exchanged; all other variables (inputs, parameters,
    internals) as they stand when the exchange is done. Where they are written to a folder, that is done block
    by block; else the block is the whole run's, and `memory` gives it, all NaN, where the run is guarded.

    The `header` says what is recorded, `rows` counts the points, of which the `cells` of `under_way` tell.
    Each column has its slave, variable and position among the outputs read (`sources`), None for variables
    that are got anew after the exchange (`late`, by slave).
    """

    def __init__(
        self,
        network: Network,
        names: Sequence[str],
        points: CommunicationPoints,
        folder: Values | None,
        memory: Callable[[int, int], Array] | None,
    ) -> None:
        names = tuple(dict.fromkeys(names))
        self.points, self._network, self._folder = points, network, folder
        self.rows = self._base = 0
        self.cells = under_way.here.cells
        units: dict[str, str | None] = {}
        types: dict[str, str] = {}
        self.sources: list[tuple[int, str, int | None]] = []
        for name in names:
            k, variable = network.locate(name)
            about = network.slaves[k].variables[variable]
            if not is_number(about):
                raise InputError(f"{name}: a {about.type} cannot be recorded; choose a scalar number")
            units[name] = about.unit
            if about.type in WHOLE:
                types[name] = WHOLE[about.type]
            read = network.reads[k]
            self.sources.append((k, variable, read.index(variable) if variable in read else None))
        late: list[dict[int, str]] = [{} for _ in network.slaves]
        for c, (k, variable, position) in enumerate(self.sources):
            if position is None:
                late[k][c] = variable
        self.late: list[Names] = [tuple(of.values()) for of in late]
        self._others = [(k, self.late[k], list(of)) for k, of in enumerate(late) if of]
        self._exchanged = [(c, k, p) for c, (k, _, p) in enumerate(self.sources) if p is not None]
        self.header = RecordTable(names, units, points, np.empty((0, len(names))), types)
        self._whole = [(names.index(name), kind) for name, kind in types.items()]
        shape = points.count + 1, len(names)
        size = 8 * shape[0] * shape[1]
        if folder is None and size > MOST_BYTES:
            raise InputError(
                f"{shape[0] - 1:.10g} steps of {shape[1]} variables are {size / 1e9:.3g} GB, and a run keeps "
                f"at most {MOST_BYTES / 1e9:g} GB in memory; take longer steps, watch less, or stream to "
                f"disk with {argument('long_run')}"
            )
        if folder is not None:
            folder.open(self.header)
            shape = min(BLOCK_ROWS, shape[0]), shape[1]
        self._block = np.full(shape, np.nan) if folder or not memory else memory(*shape)

    @property
    def left(self) -> Array:
        """Rows of the block that are still free, shape (rows, names); Booleans are 0 and 1 there."""
        return self._block[self.rows - self._base :]

    def take(self) -> None:
        """Keep the values of the next communication point."""
        row = self.left[0]
        outputs = self._network.outputs
        for column, k, position in self._exchanged:
            row[column] = outputs[k][position]
        for k, names, columns in self._others:
            row[columns] = got = self._network.slaves[k].get(names)
            for column, kind in self._whole:
                if column in columns:
                    row.view(kind)[column] = got[columns.index(column)]
        for column, kind in self._whole:
            slave, _, at = self.sources[column]
            if at is not None:
                row.view(kind)[column] = outputs[slave][at]
        self.filled(self.rows)

    def filled(self, point: int) -> None:
        """Note that all rows up to a point are filled; write a full block to the folder."""
        self.rows = self.cells[under_way.ROWS] = point + 1
        if len(self.left) == 0 and self.rows <= self.points.count:
            self.flush()

    def flush(self) -> None:
        """Write what the block holds to the folder and begin it anew."""
        if self._folder is not None:
            self._folder.put(self._base, self._block[: self.rows - self._base])
            self._base = self.rows

    def resume(self, rows: int) -> None:
        """Go on behind rows that the folder holds already."""
        self.rows = self._base = self.cells[under_way.ROWS] = rows

    def table(self) -> RecordTable:
        """Give everything recorded."""
        rest = self._block[: self.rows - self._base]
        return self.header.holding(rest if self._folder is None else self._folder.values(self._base, rest))
