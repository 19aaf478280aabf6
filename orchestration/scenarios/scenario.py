"""Scenarios: a system, what drives it, what is scored, how it is run, and what a file may say of that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.orchestration.catalogue import Controller, controller_named, shipped
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.machine.machine import Machine, merged
from warmlink.orchestration.machine.roles import AS_THEY_ARE, Sensors
from warmlink.orchestration.machine.shipped import WARMUP_CELL
from warmlink.orchestration.master.algorithms import DEFAULT_MASTER
from warmlink.orchestration.scenarios import mismatch
from warmlink.orchestration.scenarios.duties.duty import Drive
from warmlink.orchestration.scenarios.mismatch import Mismatch
from warmlink.orchestration.scenarios.overrides import given_values, refuse_fed, start_values
from warmlink.orchestration.system.model import StartValues, System, Value
from warmlink.orchestration.text_files import is_file, read_toml
from warmlink.orchestration.written.entries import Names, OneOf, Quantity, Text, Values
from warmlink.orchestration.written.tables import Table

MATERIALS = Path(__file__).parent / "materials.toml"
_WORDS = ("about", "source", "family")

DEFAULT_SCENARIO = "warm_up"
DEFAULT_TOLERANCE = 5e-6
DEFAULT_STEP = 1.0
DEFAULT_CONTROLLER = "lag"
NO_CONTROLLER = "none"

LONGEST = 365 * 86400.0
"""Longest time in s that a scenario may simulate."""

MOST_POINTS = 1_000_000
"""Most communication points that a run may keep in memory, fewer if several instances are controllers."""


@dataclass(frozen=True)
class Scenario:
    """What to run, and how; `step_size` is in s, `tolerance` and `coupling_tolerance` in m.

    Attributes
    ----------
    coupling_tolerance : largest coupling error of a run, for which steps may be smaller; None: any
    parameters : start values as written, `"2 W/K"` under `motor.joint_conductance`
    controller : the law that all controllers of the system use
    sensors : thermometers that the controllers use; a value of None there means the system's own
    differences : mismatches that change the parameters, each once
    believed : the parameters without the mismatches, which a designer may know; None without mismatches
    file : the file that it was read from; None for a shipped scenario
    remarks : sentences on what was asked for and not done, as a mismatch that was given twice
    """

    name: str
    title: str
    about: str
    duty: Drive
    machine: Machine = WARMUP_CELL
    step_size: float = DEFAULT_STEP
    master: str = DEFAULT_MASTER
    controller: Controller = field(default_factory=lambda: shipped(DEFAULT_CONTROLLER))
    tolerance: float = DEFAULT_TOLERANCE
    coupling_tolerance: float | None = None
    parameters: dict[str, str | float] = field(default_factory=dict)
    sensors: Sensors = AS_THEY_ARE
    differences: tuple[Mismatch, ...] = ()
    believed: dict[str, str | float] | None = None
    file: Path | None = None
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "machine", self.machine.driven_by(self.duty.tables))

    @property
    def stop_time(self) -> float:
        """Stop time in s, that of what drives the system."""
        return self.duty.stop_time

    @property
    def mismatches(self) -> tuple[str, ...]:
        """Names of the mismatches that change the parameters."""
        return tuple(each.name for each in self.differences)

    @property
    def as_believed(self) -> Scenario:
        """The scenario without its mismatches."""
        if self.believed is None:
            return self
        return replace(self, parameters=self.believed, differences=(), believed=None)

    @property
    def in_use(self) -> Sensors:
        """Thermometers that the controllers use."""
        said = {name: value for name, value in vars(self.sensors).items() if value is not None}
        return replace(self.machine.sensors, **said)

    @property
    def design(self) -> StartValues | None:
        """Parameters of the controllers for this system; None if the law has no design for it."""
        if self.machine.designs is None:
            return {}
        return self.machine.designs(self.controller.name, self.in_use)

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that the system needs."""
        return self.machine.kinds | self.controller.kinds

    @property
    def declared(self) -> dict[str, Component]:
        """Declaration of each instance that is a component of warmlink."""
        return self.machine.declared(self.controller.component)

    def files(self, store: FmuStore) -> dict[str, Path]:
        """Files of all FMUs by the component's name; what is missing is built; raises InputError."""
        files = store.files(sorted(self.kinds))
        return {**files, **self.machine.foreign, **store.of_controller(self.controller)}

    def values(self) -> dict[str, dict[str, Value]]:
        """Start values in SI units by instance and variable.

        Raises InputError if the scenario names a parameter or unit that does not exist, a component refuses a
        value, or the run would be too long.
        """
        self._check_extent()
        noise = self.in_use.noise
        given, driven = start_values(self.parameters, self.declared, self.name), self.duty.start_values()
        self._check_driven(given, driven)
        self._check_fed(given)
        chosen = merged(
            self.machine.nominal,
            {} if noise is None else self.machine.noisy(noise),
            self.design or {},
            given,
            driven,
        )
        if "tolerance" in self.controller.component.p.index:
            for instance in self.machine.controllers:
                chosen.setdefault(instance, {}).setdefault("tolerance", self.tolerance)
        return chosen

    def mismatched(self, difference: Mismatch) -> Scenario:
        """The scenario with a mismatch added, unknown to the controller; raises as `Mismatch.on`.

        A mismatch that the scenario has already is not applied a second time; the remarks say so.
        """
        if difference in self.differences and not difference.changes_nothing:
            told = f"the mismatch {difference.name} is there already; it counts once"
            return replace(self, remarks=tuple(dict.fromkeys((*self.remarks, told))))
        return replace(
            self,
            parameters=difference.on(self.parameters, self.machine, self.declared),
            differences=(*self.differences, difference),
            believed=self.parameters if self.believed is None else self.believed,
        )

    def _check_driven(self, given: StartValues, driven: StartValues) -> None:
        """Refuse a parameter that the duty cycle sets to something else, and that would have no effect."""
        for instance, values in driven.items():
            for name, value in given.get(instance, {}).items():
                if values.get(name, value) != value:
                    raise InputError(
                        f"{self.name}: {instance}.{name} is set by the duty cycle {self.duty.name}; give "
                        "another duty cycle, or segments of your own in the scenario's file"
                    )

    def _check_fed(self, given: StartValues) -> None:
        """Refuse a start value of an input that a wire feeds, which would have no effect."""
        for instance, values in given.items():
            for name in values:
                refuse_fed(f"{instance}.{name}", self.machine.fed, self.name)

    def _check_extent(self) -> None:
        """Refuse a run that is too long, or of more communication points than fit into memory."""
        stop, step, most = (
            self.stop_time,
            self.step_size,
            MOST_POINTS // max(1, len(self.machine.controllers)),
        )
        if stop > LONGEST:
            raise InputError(
                f"{self.name}: the stop time {stop:g} s is more than a year ({LONGEST:g} s), in which every "
                "cell has long been warm; give a shorter one"
            )
        if stop / step > most:
            raise InputError(
                f"{self.name}: {stop:g} s in steps of {step:g} s are {stop / step:.3g} "
                f"communication points, and a run keeps at most {most} in memory; take a longer step or "
                "a shorter time, or stream it to disk with `warmlink simulate SYSTEM.ssp --checkpoint 3600`"
            )

    @property
    def _timed(self) -> Machine:
        return replace(self.machine, stop_time=self.stop_time, step_size=self.step_size)

    def system(self, fmus: Mapping[str, Path]) -> System:
        """The system with its FMUs, which `files` returned; raises as `values`."""
        return self._timed.system(fmus, self.controller.component.name, self.values())

    @property
    def made_from(self) -> tuple[object, ...]:
        """What its joined system is made of, its start values apart."""
        held = self.machine
        law = self.controller.name, self.controller.digest
        return held.name, dict(held.parts), held.wires, dict(held.scaled), *law

    def joined(self, values: StartValues | None = None) -> Component:
        """The system joined into one component, with start values: by default those of the scenario.

        Raises InputError if the system contains FMUs that are not made of warmlink's components, or as
        `values`.
        """
        chosen = self.values() if values is None else values
        return self._timed.joined(self.controller.component, chosen)


def changed(
    scenario: Scenario,
    controller: str | None = None,
    parameters: Mapping[str, str | float] | str | Path = MappingProxyType({}),
    mismatches: Sequence[str] = (),
) -> Scenario:
    """The scenario with the given changes, each as for `run`; what is not given stays as its file says.

    Raises InputError if a controller or mismatch does not exist.
    """
    law = scenario.controller if controller is None else controller_named(controller)
    asked = believing(replace(scenario, controller=law), given_values(parameters))
    for each in map(mismatch.load, mismatches):
        asked = asked.mismatched(each)
    return asked


def believing(scenario: Scenario, given: Mapping[str, str | float]) -> Scenario:
    """The scenario with start values that whoever designs for it knows; its mismatches come on top."""
    known = scenario.as_believed
    named = {full: value for name, value in given.items() for full in scenario.machine.addressed(name)}
    asked = replace(known, parameters={**known.parameters, **named})
    for each in scenario.differences:
        asked = asked.mismatched(each)
    return asked


@cache
def materials() -> dict[str, dict[str, str]]:
    """Materials by name and by family: `about`, `source` and the values of their properties with units."""
    found = read_toml(MATERIALS)
    return {**found, **{each["family"]: each for each in found.values() if "family" in each}}


@dataclass(frozen=True, kw_only=True)
class Settings(Table):
    """What any scenario file may say."""

    system: Annotated[str, Text(WARMUP_CELL.name)] = WARMUP_CELL.name
    title: Annotated[str | None, Text()] = None
    about: Annotated[str | None, Text()] = None
    step_size: Annotated[float | None, Quantity("s", positive=True)] = None
    master: Annotated[str | None, Text("gauss_seidel")] = None
    controller: Annotated[str | None, Text("observer")] = None
    tolerance: Annotated[float | None, Quantity("m", positive=True)] = None
    coupling_tolerance: Annotated[float | None, Quantity("m", positive=True)] = None
    materials: Mapping[str, Annotated[str, OneOf(tuple(materials()))]] = field(default_factory=dict)
    parameters: Values = field(default_factory=dict)
    mismatches: Annotated[tuple[str, ...], Names("draw_1")] = ()
    sensors: Sensors = AS_THEY_ARE

    def applied(self, default: Scenario, folder: Path = Path()) -> Scenario:
        """The scenario changed as the file says; what the file leaves out stays.

        Files of mismatches are looked for beside the scenario's own, in `folder`, and then from here.

        Raises InputError if the controller or a mismatch does not exist.
        """
        names = ("title", "about", "step_size", "master", "tolerance", "coupling_tolerance")
        given = {name: value for name in names if (value := getattr(self, name)) is not None}
        parameters: dict[str, str | float] = {
            f"{instance}.{name}": figure
            for instance, material in self.materials.items()
            for name, figure in materials()[material].items()
            if name not in _WORDS
        }
        asked = replace(default, **given, sensors=self.sensors)
        own = {**parameters, **self.parameters}
        beside = [str(folder / each) if is_file(folder / each) else each for each in self.mismatches]
        return changed(asked, self.controller, own, beside)
