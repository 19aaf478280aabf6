"""What a run streamed into a folder, finished or not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from warmlink.orchestration.master.communication import CommunicationPoints
from warmlink.orchestration.master.recording.recorder import COLUMNS, VALUES
from warmlink.orchestration.master.recording.result import RecordTable


def read_folder(folder: Path) -> RecordTable:
    """Its columns; the values are mapped, as long as they are there."""
    about = json.loads((folder / COLUMNS).read_text(encoding="utf-8"))
    units = {column["name"]: column["unit"] for column in about["columns"]}
    points = CommunicationPoints(about["start_time_s"], about["step_size_s"], about["steps"])
    return RecordTable(tuple(units), units, points, np.load(folder / VALUES, mmap_mode="r"))
