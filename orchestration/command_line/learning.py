"""A law learnt from logs, as `warmlink design --data` asks for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from warmlink.orchestration.console import answer, answer_json
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.progress import spinner


def learn(
    logs: Sequence[Path],
    law: str,
    sensors: Sequence[str] | None,
    stds: tuple[str | None, str | None],
    sample_time: str,
    scenario: str | None,
    settings: Mapping[str, str],
    units: Sequence[str],
    names: Sequence[str],
    decimal: str,
    path: Path,
    report: Path | None,
    json: bool,
) -> None:
    """Learn a law, write its parameters and page, and answer; `stds` of a thermometer and the camera."""
    from warmlink.orchestration.diagnosis.data.columns import read_options
    from warmlink.orchestration.machine import DEFAULT
    from warmlink.orchestration.replay.learn import LearntLaw
    from warmlink.orchestration.studies.design import design

    with spinner("Learning") as progress:
        progress("reading")
        found = design(
            scenario or DEFAULT,
            law,
            sensors,
            sensor_std=stds[0],
            camera_std=stds[1],
            sample_time=sample_time,
            parameters=settings,
            data=[*logs],
            options=read_options(units, names, decimal),
        )
        assert isinstance(found, LearntLaw)
        told = found.summary()
        if report is not None:
            from warmlink.orchestration.report.learning import write_learnt

            with fresh_file(report) as target:
                write_learnt(found, target)
        found.write(path)
    if json:
        answer_json({**found.to_dict(), "values": str(path)})
    else:
        answer(told)
        answer(f"values  {path}")
        if report is not None:
            answer(f"report  {report}")
