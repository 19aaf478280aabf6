"""The twin beside a running machine: opened in one call."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from warmlink.controllers.design.shipped import PLANT_FACTS
from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import Answer
from warmlink.orchestration.diagnosis.data.inputs import of_scenario
from warmlink.orchestration.diagnosis.data.options import read_options
from warmlink.orchestration.files import locked_folder
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.scenarios.overrides import start_value
from warmlink.orchestration.watch.law import WatchedLaw, law_named
from warmlink.orchestration.watch.offers import Design
from warmlink.orchestration.watch.page import served, write_watch
from warmlink.orchestration.watch.sources.opening import opened
from warmlink.orchestration.watch.watching import Watching, WatchOptions, rate_of
from warmlink.orchestration.written.quantities import positive


class WatchedLog(Answer):
    """What a watch of a log told."""

    def __init__(self, events: list[dict[str, Any]], remarks: list[str]) -> None:
        self.events, self.remarks = events, remarks

    @property
    def alarms(self) -> list[dict[str, Any]]:
        """Alarms with time in s, verdict and causes, without those that name one anew."""
        return [each for each in self.events if each["alarm"] and "again" not in each]

    def summary(self) -> str:
        """A line for each alarm."""
        lines = [f"{each['time_s']:.0f} s: {each['verdict']}: {each['told']}" for each in self.alarms]
        return "\n".join(lines or ["no alarm"])


def watch(
    source: str | Path,
    *,
    sound: str = "24 h",
    alarms: str = "1 per 30 days",
    tick: str = "60 s",
    controller: str | None = None,
    controller_parameters: str | Path | None = None,
    system: str | Path | None = None,
    scenario: str | Path | None = None,
    parameters: Mapping[str, str] = MappingProxyType({}),
    out: str | Path = "out/watch",
) -> WatchedLog:
    """Watch a log to its end: when does the model, a thermometer or a clock no longer fit, and why.

    Parameters
    ----------
    source : the log, as `diagnose` takes it
    sound : how long the opening part lasts that is declared sound
    alarms : how often a false alarm is bearable
    tick : how much of the log is judged at once; less for a small machine that warms within minutes
    controller : a law that runs in shadow and is judged by the growth that it would leave; without one the
        log's column `correction` is, if it has one
    controller_parameters : parameter set (SSV) of the law
    system : the machine, which need not be a warm-up cell: a shipped one by its name, or the path of an SSP
    scenario : a scenario (TOML) of the machine instead, with its parameters
    parameters : what is known to differ from nominal, `"800 mm"` under `link.length`
    out : folder for the state and the page; a second call with the same goes on from there

    Raises
    ------
    InputError
        The log cannot be used, or is over before its sound part is.

    Examples
    --------
    >>> found = wl.watch("cell.csv", sound="24 h")
    >>> print(found)
    """
    settings = WatchSettings(sound, alarms, tick, controller, controller_parameters)
    whose = MachineSettings(system, scenario, parameters)
    with watching(str(source), Path(out), {}, settings, whose, until_end=True) as work:
        for _ in work.run():
            pass
        return WatchedLog(work.events, work.remarks())


@dataclass(frozen=True)
class WatchSettings:
    """How a log is watched, as people write it: arguments of `watch` by their names there."""

    sound: str
    alarms: str
    tick: str
    controller: str | None = None
    controller_parameters: str | Path | None = None


@dataclass(frozen=True)
class MachineSettings:
    """Which machine is watched, as people write it: arguments of `watch` by their names there."""

    system: str | Path | None = None
    scenario: str | Path | None = None
    parameters: Mapping[str, str] = field(default_factory=dict)

    def found(self) -> tuple[str, dict[str, str]]:
        """Name or path of the machine, and its parameters with units; InputError if it is given twice."""
        if self.scenario is None:
            return str(self.system or DEFAULT), dict(self.parameters)
        if self.system is not None:
            say = argument("system", self.system)
            raise InputError(f"{say}: {argument('scenario', self.scenario)} names a machine too; keep one")
        machine, parameters = of_scenario(str(self.scenario))
        return machine, {**parameters, **self.parameters}


@contextmanager
def watching(
    source: str,
    folder: Path,
    told: Mapping[str, Any],
    settings: WatchSettings,
    whose: MachineSettings,
    *,
    until_end: bool = False,
    speed: float = 0.0,
    serve: str = "",
    mapping: Path | None = None,
    diagnose: bool = False,
) -> Iterator[Watching]:
    """A watch with its source open and its folder locked; what an earlier one knew is taken up.

    Raises
    ------
    InputError
        Something that was given cannot be used.
    """
    lasting = positive(settings.sound, "s", argument("sound"))
    if not 0 <= speed < 1e9:
        raise InputError(f"{argument('speed', speed)}: is no speed; give how many times faster, or 0")
    rate = rate_of(settings.alarms, argument("alarms"))
    each = positive(settings.tick, "s", argument("tick"))
    if settings.controller is None and settings.controller_parameters is not None:
        say = argument("controller_parameters", settings.controller_parameters)
        raise InputError(f"{say}: is of no law; name the law with {argument('controller')}")
    law = settings.controller and law_named(settings.controller, settings.controller_parameters)
    machine, parameters = whose.found()
    columns = replace(read_options(**told), machine=machine)
    rig = rig_of(machine)
    known = {
        name: start_value(name, text, rig.components, argument("parameters"))
        for name, text in parameters.items()
    }
    with ExitStack() as stack:
        stack.enter_context(locked_folder(folder))
        rows = opened(source, not until_end, Watching.begin_of(folder), mapping)
        stack.callback(rows.close)
        work = Watching(
            rows,
            WatchOptions(
                rig,
                known,
                columns,
                lasting,
                rate,
                each,
                law or None,
                _design(law or None, whose),
                until_end,
                speed,
                diagnose,
            ),
            folder,
            write_watch,
        )
        stack.callback(work.close)
        work.restore()
        if serve:
            stack.enter_context(served(serve, folder))
        yield work


def _design(law: WatchedLaw | None, whose: MachineSettings) -> Design | None:
    """How the law is designed anew for other parameters of the machine; None if it has no design."""
    if law is None or law.name not in PLANT_FACTS or whose.system not in (None, DEFAULT):
        return None

    def design_for(parameters: Mapping[str, float], path: Path) -> None:
        from warmlink.orchestration.studies.design import design

        design(whose.scenario or DEFAULT, law.name, parameters=parameters).write(path)

    return design_for
