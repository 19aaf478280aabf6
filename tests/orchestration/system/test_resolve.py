"""What becomes of a value on its way: units of connectors, transformations, and which binding counts."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.system.model import (
    Capabilities,
    Connector,
    DefaultExperiment,
    FmuVariable,
    ModelInfo,
)
from warmlink.orchestration.system.ssp.net import Edge, Element, Net, Node
from warmlink.orchestration.system.ssp.parameter_values import SsvValue
from warmlink.orchestration.system.ssp.resolve import Binding, Resolver
from warmlink.orchestration.system.units import Conversion, Unit, parse_unit

TEMPERATURES = ("K", "degC", "degF")
KELVIN = {"K": lambda t: t, "degC": lambda t: t + 273.15, "degF": lambda t: (t + 459.67) / 1.8}
SIZE = {"K": 1.0, "degC": 1.0, "degF": 1.8}
"""Of a difference of 1 K."""


def unit(name: str | None) -> Unit | None:
    return None if name is None else parse_unit(name)


def fmu(unit_name: str, relative: bool = False) -> ModelInfo:
    """An FMU with an output y, an input u and a parameter p in one unit, none of which its file names."""
    variables = {
        name: FmuVariable(
            name, k, "Real", "Real", causality, "continuous", "exact", unit_name, relative=relative
        )
        for k, (name, causality) in enumerate((("y", "output"), ("u", "input"), ("p", "parameter")))
    }
    of_units = {unit_name: parse_unit(unit_name)}
    told = DefaultExperiment()
    return ModelInfo(
        Path("x.fmu"), "2.0", "X", "X", "{}", "", variables, ("y",), {}, Capabilities(), told, of_units
    )


def passed(
    source: str,
    through: tuple[str | None, ...],
    target: str,
    relative: tuple[bool, bool] = (False, False),
    change: Conversion | None = None,
    suppressed: bool = False,
    shown: str | None = None,
) -> Resolver:
    """A component a drives b, which lies in systems within systems whose connectors have units too.

    Those of a and b are `shown` in a unit that may be another one than that of their variables.
    """
    giving, taking = fmu(source, relative[0]), fmu(target, relative[1])
    elements = {(): Element(), ("a",): Element({"y": Connector("output", "Real", unit(shown))}, info=giving)}
    path: tuple[str, ...] = ()
    before = Node(("a",), "y")
    for level, name in enumerate(through):
        inner = (*path, f"s{level}")
        elements[inner] = Element({"to": Connector("input", "Real", unit(name))})
        edge = Edge(before, Node(inner, "to"))
        elements[path].connections.append(edge)
        before, path = Node(inner, "to"), inner
    end = (*path, "b")
    elements[end] = Element(
        {name: Connector("parameter" if name == "p" else "input", "Real", unit(shown)) for name in "up"},
        info=taking,
    )
    elements[path].connections.append(Edge(before, Node(end, "u"), change, suppressed))
    return Resolver(Net(elements))


def converted(resolver: Resolver, value: float) -> float:
    (link,) = resolver.connections()
    return link.factor * value + link.offset


@pytest.mark.parametrize(("source", "target"), list(product(TEMPERATURES, repeat=2)))
@pytest.mark.parametrize("through", [(), ("degF",), ("degC", "degF"), (None, "K", None)])
def test_a_temperature_stays_the_same_whatever_units_it_passes(
    source: str, through: tuple[str | None, ...], target: str
) -> None:
    for value, shown in product((-40.0, 25.0, 300.0), (None, "degF")):
        arrived = converted(passed(source, through, target, shown=shown), value)
        assert KELVIN[target](arrived) == pytest.approx(KELVIN[source](value), abs=1e-9)


@pytest.mark.parametrize(("source", "target"), list(product(TEMPERATURES, repeat=2)))
@pytest.mark.parametrize("through", [(), ("degF", "degC")])
def test_a_difference_keeps_its_size(source: str, through: tuple[str | None, ...], target: str) -> None:
    arrived = converted(passed(source, through, target, (True, True)), 10.0)
    assert arrived == pytest.approx(10.0 * SIZE[target] / SIZE[source])


def test_a_temperature_is_no_difference_where_the_units_zeros_differ() -> None:
    with pytest.raises(InputError, match="connect two differences or two temperatures"):
        list(passed("degC", (), "K", (True, False)).connections())
    assert converted(passed("K", (), "K", (True, False)), 3.0) == 3.0


def test_what_is_transformed_has_been_converted_into_the_unit_that_it_enters() -> None:
    """By SSP 4.5.2: 25 degC are 298.15 K, of which twice as much and one more is asked."""
    change = Conversion(2.0, 1.0)
    assert converted(passed("degC", (), "K", change=change), 25.0) == pytest.approx(2 * 298.15 + 1)
    shown = passed("K", (), "degC", change=Conversion(1.0, 18.0), shown="degF")
    assert converted(shown, 298.15) == pytest.approx(35.0)  # 77 degF and 18 more
    suppressed = passed("degC", (), "K", change=change, suppressed=True)
    assert converted(suppressed, 25.0) == pytest.approx(2 * 25.0 + 1)
    both = passed("K", (), "K", suppressed=True, shown="degF")
    assert converted(both, 298.15) == pytest.approx(298.15)  # 77 at both connectors


def test_units_of_two_quantities_are_refused_with_both_ends() -> None:
    with pytest.raises(InputError, match=r"a\.y -> s0\.b\.u: .*connect variables of one quantity"):
        list(passed("W", ("W",), "K").connections())


def start(resolver: Resolver, *bindings: Binding) -> tuple[dict[str, Any], list[str]]:
    """Start values of b, and what is remarked."""
    again = Resolver(resolver.net, bindings)
    return again.start_values()[("s0", "b")], again.remarks


def binding(path: tuple[str, ...], mapping: Any = None, **values: tuple[float, str | None]) -> Binding:
    given = {
        name.replace("__", "."): SsvValue(name, "Real", value, unit(of))
        for name, (value, of) in values.items()
    }
    return Binding(path, given, mapping, "set")


def test_the_last_binding_counts_in_the_unit_of_the_variable() -> None:
    net = passed("K", ("degC",), "degC", shown="degF")
    inner, outer = binding(("s0", "b"), p=(20.0, None)), binding((), s0__b__p=(300.0, "K"))
    assert start(net, inner) == ({"p": 20.0}, [])
    found, _ = start(net, inner, outer)
    assert found["p"] == pytest.approx(26.85)
    assert start(net, outer, inner)[0] == {"p": 20.0}


def test_a_value_for_a_systems_connector_goes_on_to_what_it_drives() -> None:
    found, _ = start(passed("K", ("degC",), "K"), binding(("s0",), to=(77.0, "degF")))
    assert found == {"u": pytest.approx(298.15)}


def test_a_mapping_decides_alone_which_names_are_given_and_may_transform() -> None:
    edge = Edge(Node((), "hot"), Node((), "p"), Conversion(2.0, 1.0))
    given = {"hot": (20.0, "degC"), "u": (5.0, None)}
    found, remarks = start(passed("K", ("K",), "degC"), binding(("s0", "b"), (edge,), **given))
    assert (found, remarks) == ({"p": 41.0}, [])
    absent = Edge(Node((), "cold"), Node((), "p"))
    assert start(passed("K", ("K",), "K"), binding(("s0", "b"), (absent,), **given)) == (
        {},
        ["set: its mapping names 'cold', which has no value"],
    )


def test_a_name_of_nothing_has_no_effect_and_is_remarked() -> None:
    found, remarks = start(passed("K", ("K",), "K"), binding(("s0",), b__p=(1.0, None), b__q=(2.0, None)))
    assert found == {"p": 1.0}
    assert remarks == ["set: b.q is the name of no variable and has no effect"]
