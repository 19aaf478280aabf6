"""The systems that warmlink ships: which components they hold and what is wired to what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path

from warmlink.controllers.start_values import with_scalars
from warmlink.fmus.component import Component
from warmlink.fmus.component.join import Wire, join
from warmlink.fmus.component.table import Table
from warmlink.fmus.errors import InputError
from warmlink.fmus.packaging.tabled import with_table
from warmlink.fmus.packaging.views import with_flag_wires
from warmlink.fmus.plant import ROD_WIRES, WIRES
from warmlink.fmus.recorded_duty.component import playing
from warmlink.orchestration import catalogue
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.description import read_description
from warmlink.orchestration.system.model import DefaultExperiment, StartValues, System
from warmlink.orchestration.system.units import Conversion
from warmlink.orchestration.system.write import Ports

COMPENSATOR = "compensator"
"""Instance that a controller takes; its component differs from run to run."""

PARTS = {
    **{"duty": "DutyCycle", "motor": "MotorHeatSource", "link": "ThermalLink", "heater": "Heater"},
    **{"sensors": "TemperatureSensors", "camera": "DriftCamera", COMPENSATOR: ""},
}
"""Component behind each instance of the shipped systems; empty: a controller."""


@dataclass(frozen=True)
class Blueprint:
    """A system before its FMUs exist.

    Attributes
    ----------
    components : name of the component behind each instance, `ThermalLink` behind `link`; empty: a controller
    wires : ends of each connection, as `("motor.heat_flow", "link.heat_flow")`
    signals : inputs that one signal from outside the system feeds, by the name of the signal
    instruments : sensor or camera outside the system by the output that it reads, as `sensors[1]`
    nominal : values in SI of parameters in which it differs from what its components declare
    shown_drive : start values of inputs with which the shipped SSP does something by itself
    ports : what a larger system that holds this one exchanges with it
    foreign : FMUs that came with the system, by what `components` calls them
    scaled : what a wire does besides converting units, by the input that it feeds
    tables : what instances of RecordedDuty play
    """

    name: str
    about: str
    components: Mapping[str, str]
    wires: tuple[tuple[str, str], ...] = ()
    stop_time: float = 3600.0
    step_size: float = 1.0
    signals: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    instruments: Mapping[str, str] = field(default_factory=dict)
    nominal: StartValues = field(default_factory=dict)
    shown_drive: StartValues = field(default_factory=dict)
    ports: Ports | None = None
    foreign: Mapping[str, Path] = field(default_factory=dict)
    scaled: Mapping[str, Conversion] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that the system needs, without the controllers."""
        return {kind for kind in self.components.values() if kind} - self.foreign.keys()

    @cached_property
    def fed(self) -> Mapping[str, str]:
        """The output behind each input that a wire feeds."""
        return {target: source for source, target in self.wires}

    @cached_property
    def reduced(self) -> Mapping[str, Component]:
        """Links that `warmlink reduce` made, among the FMUs that came with the system."""
        found = {kind: catalogue.reduced_link_in(path) for kind, path in self.foreign.items()}
        return {kind: each for kind, each in found.items() if each is not None}

    def declared(self, law: Component) -> dict[str, Component]:
        """Declaration of each instance that is a component of warmlink, with the controllers' law."""
        known = {**catalogue.components(), **self.reduced, law.name: law}
        kinds = self.components_with(law.name)
        return {name: self._played(name, known[kind]) for name, kind in kinds.items() if kind in known}

    def _played(self, instance: str, component: Component) -> Component:
        """The declaration of an instance, with its table if it plays one."""
        return playing(component, self.tables[instance]) if instance in self.tables else component

    def called(self, short: str) -> list[str]:
        """Instances that correspond to one of the shipped systems': for `motor` all motors."""
        kinds = {PARTS.get(short), *(self.reduced if short == "link" else ())}
        return [instance for instance, each in self.components.items() if each in kinds]

    def components_with(self, controller: str | None) -> dict[str, str]:
        """Component behind each instance, once the controller's component is known."""
        return {instance: kind or str(controller) for instance, kind in self.components.items()}

    def without(self, *instances: str) -> Blueprint:
        """The same without some instances and the wires at them."""
        left = {name: kind for name, kind in self.components.items() if name not in instances}
        wires = [wire for wire in self.wires if all(end.rpartition(".")[0] in left for end in wire)]
        scaled = {end: self.scaled[end] for _, end in wires if end in self.scaled}
        tables = {name: table for name, table in self.tables.items() if name in left}
        return replace(self, components=left, wires=tuple(wires), scaled=scaled, tables=tables)

    def prefixed(self, prefix: str) -> Blueprint:
        """The same with a prefix and a dot before every instance."""
        components = {f"{prefix}.{name}": kind for name, kind in self.components.items()}
        wires = tuple((f"{prefix}.{source}", f"{prefix}.{target}") for source, target in self.wires)
        tables = {f"{prefix}.{name}": table for name, table in self.tables.items()}
        return replace(self, components=components, wires=wires, tables=tables)

    @property
    def never_joined(self) -> str:
        """Why the system cannot be one component; empty where it can."""
        if self.foreign:
            return f"contains foreign FMUs ({', '.join(self.foreign)}), whose equations are not known"
        return f"a connection scales what it carries ({', '.join(self.scaled)})" if self.scaled else ""

    def with_nominal(self, values: StartValues) -> StartValues:
        """Start values by instance and variable with the nominal ones of the system beside them."""
        return {**values, **{key: {**of, **values.get(key, {})} for key, of in self.nominal.items()}}

    def joined(self, controller: Component | None = None, values: StartValues | None = None) -> Component:
        """The system as one component.

        The component of the compensator is chosen with the controller; start values are by instance and
        variable, in SI units. InputError where that cannot be.
        """
        if self.never_joined:
            raise InputError(f"{self.name}: {self.never_joined}; run it with a master instead")
        kinds = catalogue.components() | ({} if controller is None else {"": controller})
        parts = {name: self._played(name, kinds[kind]) for name, kind in self.components.items()}
        joined = join(self.name, parts, self.wires, self.about)
        every = self.with_nominal(values or {}).items()
        given = {f"{key}.{name}": float(v) for key, of in every for name, v in of.items()}
        return replace(
            joined,
            parameters=with_scalars(joined.parameters, given),
            default_stop_time=self.stop_time,
            default_step_size=self.step_size,
        )

    def system(
        self, fmus: Mapping[str, Path], controller: str | None = None, values: StartValues | None = None
    ) -> System:
        """System with FMUs by the component's name, and start values by instance and variable in SI units.

        The component of the compensator is chosen with the controller. InputError if a value is meant for an
        instance that the system does not have, or an end, a value or a unit does not fit the FMUs.
        """
        known = {**self.foreign, **fmus}
        files = {instance: known[kind] for instance, kind in self.components_with(controller).items()}
        files |= {instance: with_table(files[instance], table) for instance, table in self.tables.items()}
        ends = {f"{name}.{each}" for name, fmu in files.items() for each in read_description(fmu).variables}
        wires = with_flag_wires(self.wires, ends)
        experiment = DefaultExperiment(0.0, self.stop_time, self.step_size)
        whole = assemble(self.name, files, wires, self.with_nominal(values or {}))
        links = tuple(
            replace(link, **asdict(self.scaled[link.target])) if link.target in self.scaled else link
            for link in whole.connections
        )
        return replace(whole, connections=links, default_experiment=experiment)


def _fan(source: str, *targets: str) -> tuple[Wire, ...]:
    return tuple((source, target) for target in targets)


_SENSED = (
    "motor.shaft_temperature",
    "motor.winding_temperature",
    "link.base_temperature",
    "link.sensor_temperature[2]",
    "link.tip_temperature",
    *(f"link.sensor_temperature[{i}]" for i in (4, 5, 6)),
)
_SHOWN = (
    ("link", "elongation"),
    (COMPENSATOR, "correction"),
    ("camera", "measured_drift"),
    ("camera", "drift_valid"),
    *(("sensors", f"reading[{i}]") for i in range(1, 9)),
)
_READ = ("shaft", "winding", "base", "middle", "tip")
"""What the channels of the cell's sensors read, and what the compensator calls the first five."""

WARMUP_CELL = Blueprint(
    name="WarmupCell",
    about="duty -> motor <-> link -> sensors and camera <-> compensator",
    components={name: kind for name, kind in PARTS.items() if name != "heater"},
    wires=(
        *_fan("duty.speed", "motor.speed", "link.speed", "camera.speed", "compensator.speed"),
        *_fan("duty.torque", "motor.torque", "compensator.torque"),
        *_fan(
            "duty.ambient_temperature",
            "motor.ambient_temperature",
            "link.ambient_temperature",
            "link.tip_sink_temperature",
            "sensors.ambient_temperature",
            "compensator.ambient_temperature",
        ),
        ("duty.pad_mode", "motor.pad_mode"),
        ("duty.pad_temperature", "motor.pad_temperature"),
        ("duty.pad_power", "motor.pad_power"),
        *WIRES,
        *((source, f"sensors.temperature[{i}]") for i, source in enumerate(_SENSED, 1)),
        *((f"sensors.reading[{i}]", f"compensator.{name}_temperature") for i, name in enumerate(_READ, 1)),
        ("link.elongation", "camera.elongation"),
        ("compensator.correction", "camera.correction"),
        ("camera.measured_drift", "compensator.measured_drift"),
        ("camera.drift_valid", "compensator.drift_valid"),
    ),
    stop_time=7200.0,
    ports=Ports(("duty",), _SHOWN),
)

BENCH_ROD = Blueprint(
    name="BenchRod",
    about="heater -> link -> sensors: a plain rod, heated at base position",
    components={"heater": "Heater", "link": "ThermalLink", "sensors": "TemperatureSensors"},
    wires=(
        *ROD_WIRES,
        *((f"link.sensor_temperature[{i}]", f"sensors.temperature[{i}]") for i in range(1, 9)),
    ),
    signals={"ambient_temperature": ("link.ambient_temperature", "link.tip_sink_temperature")},
    instruments={"link.elongation": "camera"},
    shown_drive={"heater": {"on": 1.0}},
)

BENCH_MOTOR = Blueprint(
    name="BenchMotor",
    about="a motor by itself",
    components={"motor": "MotorHeatSource"},
    instruments={"motor.shaft_temperature": "sensors[1]", "motor.winding_temperature": "sensors[2]"},
    nominal={"motor": {"joint_conductance": 0.0}},  # no link takes heat
    shown_drive={"motor": {"speed": 3.43, "torque": 2.5}},
)

SHIPPED = {blueprint.name: blueprint for blueprint in (WARMUP_CELL, BENCH_ROD, BENCH_MOTOR)}
