"""Controllers designed for a system: the plant's parameters from its files, the gains to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from warmlink.controllers.design.gains import design_controller
from warmlink.controllers.design.linear_gains import LinearDesign, design_linear
from warmlink.controllers.design.middle import middle_advice
from warmlink.controllers.design.plant import Plant, cell_plant, no_growth
from warmlink.controllers.design.regression import fit_regression, reference_temperature_of
from warmlink.controllers.design.shipped import PLANT_FACTS
from warmlink.controllers.design.training import training_run
from warmlink.controllers.start_values import Values
from warmlink.fmus.arguments import argument
from warmlink.fmus.component import SHORTEST_SAMPLE_TIME
from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead, listed, several
from warmlink.orchestration import catalogue
from warmlink.orchestration.closed_loop.load import load_scenario
from warmlink.orchestration.closed_loop.training import refuse_unread, run_of, runs_of
from warmlink.orchestration.console import Answer, remark
from warmlink.orchestration.diagnosis.data.inputs import of_scenario
from warmlink.orchestration.diagnosis.data.options import DEFAULT_OPTIONS, ReadOptions
from warmlink.orchestration.files import temporary_folder
from warmlink.orchestration.machine import DEFAULT
from warmlink.orchestration.machine.plant import plant_of
from warmlink.orchestration.machine.roles import AS_THEY_ARE
from warmlink.orchestration.machine.shipped import machine_named, machines
from warmlink.orchestration.replay.learn import LearntLaw, learnt_law
from warmlink.orchestration.scenarios.law_values import source_named, start_values_of, write_law_values
from warmlink.orchestration.scenarios.overrides import given_values
from warmlink.orchestration.scenarios.replaced import with_replaced
from warmlink.orchestration.scenarios.scenario import DEFAULT_SCENARIO, NO_CONTROLLER, Scenario, changed
from warmlink.orchestration.studies.plants import cell_plant_in, plant_in, with_values
from warmlink.orchestration.system.assemble import path_and_variant, read_system
from warmlink.orchestration.system.replacement import NOTHING_REPLACED, Replacements
from warmlink.orchestration.written.quantities import positive

if TYPE_CHECKING:
    from warmlink.controllers.design.reduction import ReducedPlant
    from warmlink.orchestration.replay.logs import Logs

SENSORS, SENSOR_STD = ("base", "tip"), 0.1
"""Defaults of a design: the temperatures that the law uses, and the noise of a reading in K."""

WITH_CAMERA, OF_ANY_FMUS = "observer_drift", "linear_observer"
"""The law that uses the camera, and the observer whose model is found from runs."""


@dataclass(frozen=True, repr=False)
class Designed(Answer):
    """A controller's gains for a system.

    Attributes
    ----------
    law : name of the controller
    sensors : temperatures that it uses
    values : parameters of its component
    plant : what it was designed for; None where that was a run of FMUs
    reduced : the model that it holds; None for a law without one, or that was found from runs
    found : the model that was found from runs of FMUs, and what the law is worth; None for another law
    source : what it was made from: the system or scenario with the hash of its file, and what was changed
    """

    law: str
    sensors: tuple[str, ...]
    values: Values
    plant: Plant | None
    reduced: ReducedPlant | None = None
    found: LinearDesign | None = None
    source: str = ""

    @property
    def given(self) -> dict[str, float]:
        """Parameters of the system's motors and links that differ from nominal, in SI units."""
        return {} if self.plant is None else dict(self.plant.given)

    @property
    def parameters(self) -> dict[str, float]:
        """Start values for `run` and `compare`, in SI units."""
        return start_values_of(self.values)

    def write(self, path: str | Path) -> None:
        """Write the parameter set (SSV) of the law's FMU; raises InputError where that cannot be done."""
        write_law_values(self.law, self.values, path, f"{self.law}, designed", self.source)

    def to_dict(self) -> dict[str, Any]:
        """For JSON, the gains apart."""
        facts: dict[str, Any] = {"law": self.law, "sensors": list(self.sensors)}
        if self.reduced is not None:
            facts |= {
                "modes": self.reduced.order,
                "reduction_error_um": 1e6 * self.reduced.error.elongation_step,
                "reduction_error_K": self.reduced.error.temperature_step,
            }
        if self.found is not None:
            facts |= {"modes": self.found.model.order, "removed": asdict(self.found.worth)}
        return {**facts, "plant": self.given}

    def summary(self) -> str:
        """The design in a few lines."""
        lines = [f"{self.law} from {', '.join(self.sensors) or 'the duty alone'}"]
        if self.reduced is not None:
            error = self.reduced.error
            lines.append(
                f"{self.reduced.order} modes; the reduction costs at most "
                f"{1e6 * error.elongation_step:.2g} µm and {error.temperature_step:.2g} K"
            )
        if self.found is not None:
            return "\n".join([*lines, *self.found.told()])
        known = listed(list(self.given)) + " changed from nominal" if self.given else "nominal"
        lines.append(f"plant: {'as in a run of its FMUs' if self.plant is None else known}")
        advice = None if self.reduced is None or self.plant is None else middle_advice(self.plant)
        return "\n".join([*lines, *([advice] if advice else [])])


def design(
    system: str | Path = DEFAULT,
    law: str = "observer",
    sensors: Sequence[str] | str | None = None,
    *,
    sensor_std: str | float | None = None,
    camera_std: str | float | None = None,
    sample_time: str | float = 1.0,
    parameters: Mapping[str, str | float] = MappingProxyType({}),
    replaced: Replacements = NOTHING_REPLACED,
    data: Logs | None = None,
    options: ReadOptions = DEFAULT_OPTIONS,
) -> Designed | LearntLaw:
    """Compute a controller's gains for a system, or learn them from measured logs.

    Parameters
    ----------
    system : WarmupCell, an SSP with one motor and one link, or a scenario (TOML) of any motors and links; for
        the linear observer and the regression, which are found from runs of it, a scenario with any FMUs
    law : observer, observer_drift, linear_observer or regression
    sensors : temperatures that the law uses: any of shaft, winding, base, middle, tip; by default those that
        the scenario says, or base and tip
    sensor_std : standard deviation of the noise of a thermometer in K; what the scenario says, or 0.1 K
    camera_std : that of the camera in m
    sample_time : time between two corrections, in s
    parameters : changes of the plant's parameters, `"2 W/K"` under `motor.joint_conductance`
    replaced : FMUs in place of parts; of those that `warmlink reduce` made the equations are known
    data : logs (files or DataFrames) of one machine to learn the regression from, columns as `diagnose` reads
        them; if the system is a scenario, its roles say what they are, and its model helps where little was
        measured
    options : units and names of the logs' columns

    Raises
    ------
    InputError
        If there is no such law, sensor or system, or a value is out of range.

    Examples
    --------
    >>> designed = wl.design("WarmupCell", "observer", ["base", "tip"], parameters={"link.length": "400 mm"})
    >>> designed.write("observer.ssv")
    >>> wl.run("stop_and_go", "observer", parameters="observer.ssv")
    """
    if camera_std is not None and law != WITH_CAMERA:
        raise InputError(
            f"{argument('camera_std', camera_std)}: {law} does not use the camera; {WITH_CAMERA} does"
        )
    if data is not None:
        stds = sensor_std, camera_std
        return _learnt(data, system, law, sensors, stds, sample_time, parameters, options)
    if law not in PLANT_FACTS:
        raise InputError(f"{argument('law', law)}: has no design; {instead(law, PLANT_FACTS)}")
    parameters = given_values(parameters)
    scenario, source = None, f"designed for {source_named(system, parameters)}"
    if str(system).endswith(".toml") or replaced.fmus:
        read = load_scenario(DEFAULT_SCENARIO if system == DEFAULT else str(system))
        scenario = changed(with_replaced(read, replaced), controller=law, parameters=parameters)
    known = AS_THEY_ARE if scenario is None else scenario.in_use
    sensors = known.used or SENSORS if sensors is None else several(sensors)
    usual = known.noise or SENSOR_STD
    noise = positive(usual if sensor_std is None else sensor_std, "K", argument("sensor_std"))
    period = positive(sample_time, "s", argument("sample_time"))
    if period < SHORTEST_SAMPLE_TIME:
        raise InputError(
            f"{argument('sample_time', sample_time)}: is too short; give at least {SHORTEST_SAMPLE_TIME:g} s"
        )
    held = None if scenario is None else scenario.machine
    if law == OF_ANY_FMUS:
        read = changed(scenario or load_scenario(DEFAULT_SCENARIO), controller=law, parameters=parameters)
        made = _from_runs(read, str(system), sensors, noise, period)
        return Designed(law, tuple(sensors), made.parameters, None, found=made, source=source)
    foreign = law == "regression" and held is not None and held.foreign.keys() - held.reduced.keys()
    plant = None if foreign else _plant(str(system), parameters) if scenario is None else plant_in(scenario)
    if scenario is not None and plant is not None:
        refuse_unread(scenario.machine, sensors, plant.read)
    if law == "regression" and not sensors:
        raise InputError(f"{argument('sensors')}: a regression goes by thermometers alone; name one or more")
    if law == "regression":
        if scenario is None or plant is not None:
            facts = {"reference_temperature": no_growth(plant or cell_plant())}
            values = {**fit_regression(training_run(plant), list(sensors), noise), **facts}
        else:
            run = run_of(scenario, sensors)
            values = fit_regression(run, list(sensors), noise, reference_temperature_of(run, sensors))
        return Designed(law, tuple(sensors), {**values, "sample_time": period}, plant, source=source)
    camera = None if camera_std is None else positive(camera_std, "m", argument("camera_std"))
    found = design_controller(law, list(sensors), noise, period, plant, camera_std=camera)
    return Designed(law, tuple(sensors), found.parameters, plant, found.reduced, source=source)


def _learnt(
    data: Logs,
    system: str | Path,
    law: str,
    sensors: Sequence[str] | str | None,
    stds: tuple[str | float | None, str | float | None],
    sample_time: str | float,
    parameters: Mapping[str, str | float],
    options: ReadOptions,
) -> LearntLaw:
    """The law learnt from logs; a system other than the nominal cell is a model of the machine.

    The roles of a scenario say what the columns are. `stds` are those of a thermometer and of the camera.
    """
    plant = None
    if str(system).endswith(".toml"):
        options = replace(options, machine=of_scenario(str(system))[0])
        plant = _model_of(changed(load_scenario(str(system)), controller=law, parameters=parameters))
    elif system != DEFAULT or parameters:
        plant = _plant(str(system), parameters)
    names = None if sensors is None else several(sensors)
    noise, camera = (
        None if std is None else positive(std, unit, argument(name))
        for std, unit, name in zip(stds, ("K", "m"), ("sensor_std", "camera_std"), strict=True)
    )
    return learnt_law(
        data,
        law,
        names,
        sensor_std=noise,
        camera_std=camera,
        sample_time=sample_time,
        plant=plant,
        model=source_named(system, parameters),
        options=options,
    )


def _model_of(scenario: Scenario) -> Plant | None:
    """The plant of a scenario, as a model beside logs; None if its equations are not known, which is said.

    InputError for a value that is refused, or a law that needs a model.
    """
    scenario.values()
    try:
        return plant_in(scenario)
    except InputError as why:
        if scenario.controller.name != "regression":
            raise
        remark(f"{why}; the law is learnt from the logs alone")
        return None


def _plant(system: str, given: Mapping[str, str | float]) -> Plant:
    """Motor and link of a system, other parameters given."""
    if system in machines():
        machine = machine_named(system)
        if not (machine.called("motor") and machine.called("link")):
            raise InputError(
                f"{system}: has no motor with a link; design for {DEFAULT} or an .ssp of your own"
            )
        declared = machine.declared(catalogue.controller(NO_CONTROLLER))
        return with_values(plant_of(machine, declared, machine.nominal), given)
    with temporary_folder() as work:
        path, variant = path_and_variant(system)
        read = read_system(path, work, variant)
        for told in read.remarks:
            remark(told)
        return with_values(cell_plant_in(read), given)


def _from_runs(
    scenario: Scenario, system: str, sensors: Sequence[str], noise: float, period: float
) -> LinearDesign:
    """A linear observer from runs of a scenario's FMUs; InputError where it would be worse than none."""
    if not (system == DEFAULT or system.endswith(".toml")):
        raise InputError(
            f"{system}: a law that is found from runs needs a duty cycle, and roles of variables; name a "
            "scenario file (TOML) with system and [roles]"
        )
    *runs, judge, own = runs_of(scenario, sensors)
    found = design_linear(runs, [judge, own], sensors, noise, period)
    if not found.worth.observer > 0:
        known = listed([*sensors, "the duty"])
        raise InputError(
            f"{scenario.machine.name}: {known} do not show its growth: the law would be off by "
            f"{1e6 * found.worth.left:.3g} µm, as far as no controller; wire a thermometer near to what grows"
        )
    return found
