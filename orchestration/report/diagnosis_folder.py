"""The folder of a diagnosis: its page, `diagnosis.json`, the extended model and the next experiment."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warmlink.orchestration.diagnosis.answer.diagnosis import Diagnosis
from warmlink.orchestration.diagnosis.answer.entries import json_content
from warmlink.orchestration.diagnosis.answer.extension import extended_values, write_ssp_of
from warmlink.orchestration.diagnosis.diagnose import DUTY, SCENARIO, write_next
from warmlink.orchestration.files import fresh_folder
from warmlink.orchestration.report.diagnosis import write_report
from warmlink.orchestration.system.ssp.parameter_values import write_ssv

if TYPE_CHECKING:
    from warmlink.orchestration.fmu_store import FmuStore

SSV, SSP, JSON, PAGE = "extended.ssv", "extended.ssp", "diagnosis.json", "report.html"


def write_diagnosis(diagnosis: Diagnosis, folder: Path, store: FmuStore | None = None) -> dict[str, Path]:
    """Write `diagnosis.json`, the page, the extended model, and the next experiment where one is proposed.

    Parameters
    ----------
    diagnosis : what was found
    folder : where to; made if need be
    store : FMUs for the extended `.ssp`; without them only the `.ssv` is written

    Returns
    -------
    dict
        Paths by name of the file.
    """
    values = extended_values(diagnosis.assessment.problem, diagnosis.adopted.fit)
    with fresh_folder(folder) as work:
        write_ssv(values, work / SSV, name="extended")
        if store is not None:
            write_ssp_of(diagnosis.experiment.rig, values, work / SSP, store)
        _write_json(json_content(diagnosis, SSV, SSP if store is not None else None), work / JSON)
        write_report(diagnosis, work / PAGE)
        if diagnosis.proposed is not None and diagnosis.proposed.duty:
            write_next(diagnosis.proposed, diagnosis.experiment.rig, diagnosis.experiment.known, work)
        names = [path.name for path in work.iterdir()]
    for name in {SCENARIO, DUTY} - set(names):  # an older proposal would be taken for today's
        (folder / name).unlink(missing_ok=True)
    return {name: folder / name for name in names}


def write_diagnoses(parts: Mapping[str, Diagnosis], whole: dict[str, Any], folder: Path) -> None:
    """Write a folder for each part of a machine, and `diagnosis.json` with what is said of the whole."""
    for name, each in parts.items():
        write_diagnosis(each, folder / name)
    with fresh_folder(folder) as work:
        _write_json(whole, work / JSON)


def _write_json(content: dict[str, Any], path: Path) -> None:
    """Write a JSON file that people can read too."""
    text = json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
