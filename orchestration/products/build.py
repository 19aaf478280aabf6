"""FMUs and systems for other tools."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from warmlink.fmus.arguments import argument
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, several
from warmlink.fmus.packaging.native.fmu import FmiVersion
from warmlink.orchestration.closed_loop.belief import design_check
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import fresh_folder, temporary_folder
from warmlink.orchestration.fmu_store import BuildProgress
from warmlink.orchestration.machine.machine import Machine
from warmlink.orchestration.progress import progress_bar
from warmlink.orchestration.scenarios.scenario import Scenario
from warmlink.orchestration.system.model import SspVersion
from warmlink.orchestration.system.write import ssp_version_named

KINDS = ("native", "python", "all")

_VERSIONS: Mapping[str, FmiVersion] = {"3": "3.0", "2": "2.0"}
"""Versions of FMI in the order of building: of files with one name, a system holds the one built last."""

SHOWN_CONTROLLER = "lag"
"""Controller in a shipped SSP that runs no scenario; any FMU with its connectors can replace it."""

JOINED_HOME = "warmlink.orchestration.machine.machine"
"""Module of the joined systems, without a README: their documentation lists variables alone."""


def build(
    names: Sequence[str] | str = (),
    out: str | Path = "dist",
    *,
    fmus: str = "all",
    fmi: str | float | None = None,
    ssp: str | int = 1,
    platforms: str | None = None,
    scenario: str | Path | None = None,
    valid_flags: bool = False,
    arrays: bool = False,
) -> list[Path]:
    """Build the FMUs and the systems (SSP) for other tools, validate each of them, and give their files.

    A system with a controller is built as one native FMU, too, unless it holds FMUs from elsewhere.

    Parameters
    ----------
    names : components, controllers and systems, a system with the FMUs that it holds; all by default
    out : folder
    fmus : native, python or all
    fmi : version of FMI of the native FMUs, 2 or 3; both by default
    ssp : version of SSP of the systems, 1 or 2
    platforms : of the native FMUs, such as `x86_64-linux,x86_64-windows`, or all; this computer's by default
    scenario : file (TOML) of a system of one's own, which is built in place of the shipped ones
    valid_flags : give each reading a flag of whether it is valid, in place of NaN; wants `fmus="native"`, and
        no scenario
    arrays : arrays in the native FMUs of FMI 3.0

    Raises
    ------
    InputError
        If a name, the kind, a version or a platform does not exist, or the folder cannot be written.

    Examples
    --------
    >>> wl.build("ThermalLink", fmus="native", fmi=2)
    """
    named, version = several(names), None if fmi is None else str(fmi).removesuffix(".0")
    if fmus not in KINDS:
        raise InputError(f"{argument('fmus', fmus)}: no such kind; {instead(fmus, KINDS)}")
    if valid_flags and (fmus != "native" or scenario is not None):
        shipped = f"give {argument('fmus', 'native')}, no {argument('scenario')}"
        raise InputError(f"{argument('valid_flags')}: is for the shipped native FMUs; {shipped}")
    if version not in (None, *_VERSIONS):
        raise InputError(f"{argument('fmi', fmi)}: no such version; {instead(str(fmi), _VERSIONS)}")
    ssp_version = ssp_version_named(ssp, "ssp")
    if named and scenario is not None:
        alone = f"{argument('scenario')} builds its own system alone"
        raise InputError(f"{named[0]}: {alone}; give names or a scenario")
    from warmlink.orchestration.check.fmu import validity_problems
    from warmlink.orchestration.system.assemble import read_system

    out = Path(out)
    own = None if scenario is None else load_scenario(str(scenario))
    if own is not None and (advice := design_check(own)[0]) is not None:
        remark(advice)
    chosen, versions = _chosen(named), [_VERSIONS[version]] if version else [*_VERSIONS.values()]
    with fresh_folder(out) as fresh:
        making = _Making(fmus, platforms, fresh, valid_flags, arrays, versions, ssp_version)
        try:
            built = making.shipped(chosen) if own is None else making.own(own)
        except OSError as fault:
            place = Path(fault.filename or fresh)
            shown = out if place.is_relative_to(fresh) else place
            told = f"cannot be written ({fault.strerror}); choose another {argument('out')}"
            raise InputError(f"{shown}: {told}") from None
        for path in built:
            if path.suffix != ".fmu":
                with temporary_folder() as work:
                    read_system(path, work)
            elif problems := validity_problems(path):
                raise InputError(f"{path.name}: {problems[0]}; please report this")
    return [out / path.relative_to(fresh) for path in built]


@dataclass(frozen=True)
class _Chosen:
    """Everything shipped that can be built: components by name, and systems by name."""

    components: Sequence[str]
    systems: Sequence[str]


def _chosen(names: Sequence[str]) -> _Chosen:
    """What is built for given names; InputError if nothing has a name."""
    from warmlink.orchestration.catalogue import controller, controllers, entries
    from warmlink.orchestration.machine.shipped import machine_named, machines

    systems = machines()
    known = [*entries(), *systems, *controllers()]
    for name in names:
        if name not in known:
            raise InputError(f"{name}: no such component, controller or system; {instead(name, known)}")
    full = {controllers()[name].name if name in controllers() else name for name in names}
    wanted = [name for name in systems if not names or name in full]
    for system in wanted:
        machine = machine_named(system)
        law = shown.controller.component if (shown := _showcase(machine)) else controller(SHOWN_CONTROLLER)
        full |= {*machine.parts_with(law.name).values()}
    return _Chosen([name for name in entries() if not names or name in full], wanted)


def _showcase(machine: Machine) -> Scenario | None:
    return load_scenario(machine.showcase) if machine.showcase else None


@dataclass(frozen=True)
class _Making:
    """How FMUs and systems are built; what needs no compiler comes first, what takes longest last."""

    kind: str
    platforms: str | None
    out: Path
    flags: bool
    arrays: bool
    versions: Sequence[FmiVersion]
    ssp: SspVersion

    def shipped(self, chosen: _Chosen) -> list[Path]:
        """Build shipped components and systems, and give their files."""
        from warmlink.orchestration.catalogue import controller
        from warmlink.orchestration.machine.files import write_machine
        from warmlink.orchestration.machine.shipped import machine_named

        built, law = self._components(chosen.components), controller(SHOWN_CONTROLLER)
        fmus = {path.stem: path for path in built}
        whole: list[Component] = []
        for name in chosen.systems:
            machine = machine_named(name)
            shown = _showcase(machine)
            system = shown.system(fmus) if shown else machine.system(fmus, law.name, machine.shown)
            built += write_machine(system, machine.ports, self.out, self.ssp)
            if machine.controllers:
                whole.append(shown.joined() if shown else machine.joined(law))
        return built + self._joined([self._flagged(each) for each in whole])

    def own(self, scenario: Scenario) -> list[Path]:
        """Build the system of a scenario, and give its files."""
        from warmlink.orchestration.catalogue import entries
        from warmlink.orchestration.fmu_store import FmuStore
        from warmlink.orchestration.system.write import write_ssp

        names = [name for name in entries() if name in scenario.kinds]
        built = self._components(
            names, {each.name: each for each in scenario.declared.values() if each.tables}
        )
        fmus = {path.stem: path for path in built}
        store = FmuStore("python" if self.kind == "python" else "native")
        built.append(self.out / f"{scenario.name}.ssp")
        system = scenario.system({**fmus, **store.of_controller(scenario.controller)})
        write_ssp(system, built[-1], version=self.ssp)
        # As one component, called as the scenario is; none where others' FMUs are in it.
        apart = scenario.machine.never_joined
        name = re.sub(r"\W", "_", scenario.name)
        return built + self._joined([] if apart else [replace(scenario.joined(), name=name)])

    def _flagged(self, component: Component) -> Component:
        from warmlink.fmus.packaging.views import flagged

        return flagged(component) if self.flags else component

    def _components(
        self, names: Sequence[str], playing: Mapping[str, Component] = MappingProxyType({})
    ) -> list[Path]:
        """Build components by name; those that are `playing` take the place of the shipped ones."""
        from warmlink.fmus.packaging.python.fmu import build_python_fmus
        from warmlink.orchestration.catalogue import entries

        known = ((entries()[name], playing.get(name, entries()[name].component)) for name in names)
        chosen = [replace(entry, component=self._flagged(component)) for entry, component in known]
        built: list[Path] = []
        if self.kind != "native":
            with progress_bar("Python FMUs") as progress:
                at_work = BuildProgress(progress, len(chosen))
                for each in chosen:
                    at_work.begun(each.component.name)
                    built += build_python_fmus([each], self.out / "python", at_work.done)
        return built + (_build_native(chosen, self) if self.kind != "python" else [])

    def _joined(self, components: Sequence[Component]) -> list[Path]:
        entries = [Entry(each, JOINED_HOME) for each in components]
        return _build_native(entries, self) if self.kind != "python" else []


def _build_native(components: Sequence[Entry], how: _Making) -> list[Path]:
    from warmlink.fmus.packaging.native.compile import platforms_named
    from warmlink.fmus.packaging.native.fmu import build_native_fmus

    chosen = platforms_named(how.platforms)
    built: list[Path] = []
    with progress_bar("native FMUs") as progress:
        at_work = BuildProgress(progress, len(components) * len(how.versions))
        for version in how.versions:
            folder = how.out / "native" / f"fmi{version[0]}"
            built += build_native_fmus(
                components, folder, version, chosen, at_work.done, how.arrays, at_work.begun
            )
    return built
