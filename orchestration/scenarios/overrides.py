"""Start values that people write as `"motor.joint_conductance" = "2 W/K"`, checked before anything runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.arguments import path_given
from warmlink.fmus.component import Component, Output, Scalar, limits
from warmlink.fmus.component.units import BASE_UNITS
from warmlink.fmus.component.variables import VariableType
from warmlink.fmus.errors import InputError, refusal
from warmlink.fmus.names import instead
from warmlink.orchestration.machine.machine import COMPENSATOR, DUTY
from warmlink.orchestration.system.model import Value
from warmlink.orchestration.system.ssp.parameter_values import read_ssv
from warmlink.orchestration.system.units import Unit, meaning, parse_unit
from warmlink.orchestration.written.quantities import bare, converter, quantity, refuse_bare

_TYPES: Mapping[VariableType, type[float | int | bool]] = {"Real": float, "Integer": int, "Boolean": bool}


@dataclass(frozen=True)
class StartValueSet:
    """Start values with units or in SI, under `instance.variable`, that were given together by an option."""

    origin: str
    values: Mapping[str, str | float]

    @property
    def of_compensator(self) -> dict[str, str]:
        """Variables of the compensator by their full names."""
        split = {name: name.rpartition(".") for name in self.values}
        return {name: each for name, (instance, _, each) in split.items() if instance == COMPENSATOR}

    def takers(self, controllers: Mapping[str, Component]) -> list[str]:
        """Controllers that have every variable that the set gives the compensator; InputError if none has."""
        names = set(self.of_compensator.values())
        known = {name: settable(law).keys() for name, law in controllers.items()}
        found = [name for name, variables in known.items() if names <= variables]
        if found:
            return found
        # The law that has most of them is the one that was meant.
        missing = min(names - max(known.values(), key=lambda variables: len(names & variables)))
        every = sorted(set().union(*known.values()))
        remedy = instead(missing, every, "or compare the controller that it is for")
        raise InputError(f"{self.origin}: no controller compared has {COMPENSATOR}.{missing}; {remedy}")


def start_values(
    written: Mapping[str, str | float], components: Mapping[str, Component], where: str
) -> dict[str, dict[str, Value]]:
    """Start values in SI units by instance and variable, of those with units under `instance.variable`.

    `components` has the declaration behind each instance; `where`, what the values are for, stands before an
    error message. InputError is raised if an instance or variable does not exist, a unit does not fit, or the
    component refuses a value.
    """
    values: dict[str, dict[str, Value]] = {}
    faults: list[str] = []
    for name, text in written.items():
        instance, _, variable = name.rpartition(".")
        try:
            known = scalar(name, components, where)
            value = to_si(text, known, f"{where}: {name}")
        except InputError as fault:
            faults.append(str(fault))
            continue
        typed = _TYPES[known.variable.type](value)
        values.setdefault(instance, {})[variable] = typed if typed == value else value
    for instance, chosen in values.items():
        try:
            limits.checked(components[instance], instance, {name: float(v) for name, v in chosen.items()})
        except InputError as fault:
            faults.append(str(fault))
    if faults:
        raise refusal(faults)
    return values


def refuse_fed(name: str, fed: Mapping[str, str], where: str) -> None:
    """Raise InputError if an input is fed: `fed` has the output behind each, as `motor.heat_flow`."""
    if name not in fed:
        return
    source = fed[name].rpartition(".")[0]
    remedy = f"set parameters of {source} instead"
    if source == DUTY or source.endswith(f".{DUTY}"):
        remedy = "change the duty cycle instead, as segments in a scenario's file"
    told = f"{name} is fed by {fed[name]}, so that a value set here would have no effect"
    raise InputError(f"{where}: {told}; {remedy}")


def start_value(name: str, text: str | float, components: Mapping[str, Component], where: str) -> float:
    """One start value in its SI unit; its range is not checked. Raises as `start_values`."""
    return to_si(text, scalar(name, components, where), f"{where}: {name}")


def to_si(text: str | float, scalar: Scalar, where: str, difference: bool = False) -> float:
    """SI value of `"6 W"` or `"22 degC"`, or of a bare number in SI, for a variable.

    `difference` says that it is one (a noise, an offset), even where the variable is a temperature. Raises as
    `quantity`, and where a number in SI is too high, or a temperature too cold, that would do in the unit in
    which people read the variable.
    """
    variable = scalar.variable
    unit, display, most = variable.unit, variable.display, variable.maximum
    if scalar.is_temperature and not difference and bare(text) != 0:  # 0 K may have a meaning of its own
        refuse_bare(text, unit, where)
    value = quantity(text, unit, where, difference=difference or not scalar.is_temperature)
    if display and most is not None and value > most >= converter(display, unit)(value):
        told = f"{value:g} {unit} is too high (at most {most:g} {unit})"
        if value == bare(text):
            raise InputError(f"{where}: {told}; did you mean {value:g} {display}?")
    return value


def si_in_range(text: str | float, scalar: Scalar, where: str) -> float:
    """SI value as by `to_si`; InputError also where it is out of the variable's range, or as cold as 0 K."""
    if scalar.is_temperature:
        refuse_bare(text, scalar.variable.unit, where)
    value = to_si(text, scalar, where)
    if (told := limits.problem(scalar, value)) is not None:
        raise InputError(f"{where}: {told}")
    return value


def scalar(name: str, components: Mapping[str, Component], where: str) -> Scalar:
    """The input or parameter that `instance.variable` names. Raises as `start_values`."""
    instance, _, variable = name.rpartition(".")
    where = f"{where}: {name}"
    if not instance:
        full = [f"{held}.{name}" for held, component in components.items() if name in settable(component)]
        known = instead(name, full or components, "with a dot and the variable after it")
        raise InputError(f"{where}: names no component; {known}")
    if instance not in components:
        raise InputError(f"{where}: there is no component {instance}; {instead(instance, components)}")
    found, kind = settable(components[instance]), components[instance].name
    if variable not in found:
        raise InputError(f"{where}: {kind} has no such variable; {instead(variable, found)}")
    return found[variable]


def settable(component: Component) -> dict[str, Scalar]:
    """Inputs and parameters of a component by name: the variables that have a start value."""
    return {s.name: s for s in component.scalars() if not isinstance(s.variable, Output)}


def given_values(
    given: Mapping[str, str | float] | str | Path, name: str = "parameters"
) -> dict[str, str | float]:
    """Start values that an argument of a name gives, or those of the parameter set (SSV) at its path.

    Raises InputError if it is neither, and as `parameters_of`.
    """
    return dict(given) if isinstance(given, Mapping) else parameters_of(path_given(name, given))


def parameters_of(path: Path) -> dict[str, str | float]:
    """Start values with their units by `instance.variable`; a name without an instance is the compensator's.

    Raises InputError if the file cannot be read, or contains a value that is no number.
    """
    found: dict[str, str | float] = {}
    for name, parameter in read_ssv(path).items():
        full = name if "." in name else f"{COMPENSATOR}.{name}"
        if isinstance(parameter.value, str):
            told = f"{parameter.value!r} is not a number; leave it out of the file"
            raise InputError(f"{path.name}: {name}: {told}")
        found[full] = _with_unit(float(parameter.value), parameter.unit)
    return found


def _with_unit(value: float, unit: Unit | None) -> str | float:
    """A value as people write it, so that it is read for a variable: 0.5 degC of an offset are 0.5 K."""
    if unit is None or unit.dash:
        return value
    known = meaning(unit)
    with suppress(InputError):
        if replace(parse_unit(known.name), name=known.name) == known:
            return f"{value!r} {known.name}"
    assert known.exponents is not None
    base = ".".join(
        f"{name}{power}" for name, power in zip(BASE_UNITS, known.exponents, strict=True) if power
    )
    return f"{known.factor * value + known.offset!r} {base or '1'}"


def assigned(
    sets: Sequence[StartValueSet], controllers: Mapping[str, Component]
) -> dict[str, dict[str, str | float]]:
    """Start values for each controller; InputError if none has what is set."""
    found: dict[str, dict[str, str | float]] = {name: {} for name in controllers}
    for given in sets:
        taking = given.takers(controllers)
        for law, values in found.items():
            out_of_reach = () if law in taking else given.of_compensator
            values |= {name: value for name, value in given.values.items() if name not in out_of_reach}
    return found


def reached_controllers(given: StartValueSet, controllers: Mapping[str, Component]) -> str | None:
    """Sentence that names the controllers that a set reaches; None if it sets none of their parameters."""
    taking = ", ".join(given.takers(controllers))
    return f"{given.origin}: for {taking}" if given.of_compensator else None
