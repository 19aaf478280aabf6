"""Components joined by wires: a component again, whose parts are what they were."""

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from warmlink.controllers.lag.component import COMPONENT as LAG
from warmlink.fmus.component import Component, Input, Output, Parameter, Record, State, limits
from warmlink.fmus.component.arithmetic import Number
from warmlink.fmus.component.join import join
from warmlink.fmus.drift_camera.component import COMPONENT as CAMERA
from warmlink.fmus.duty_cycle.component import COMPONENT as DUTY
from warmlink.fmus.errors import InputError
from warmlink.fmus.plant import WIRES, plant
from warmlink.fmus.temperature_sensors.component import COMPONENT as SENSORS

SPEED = ("duty.speed", "plant.motor.speed")
READ = ("plant.link.base_temperature", "sensors.temperature[3]")


def test_names_bear_the_instance_and_wired_inputs_are_gone() -> None:
    names = {scalar.name for scalar in plant().scalars()}
    assert {"motor.torque", "link.conductivity", "link.sensor_temperature[8]"} <= names
    assert not {target for _, target in WIRES} & names


def test_nesting_changes_names_and_nothing_else() -> None:
    nested = join("Nested", {"duty": DUTY, "plant": plant()}, [SPEED])
    parts = {"duty": DUTY, **{f"plant.{k}": v for k, v in plant().joint.parts.items()}}
    wires = [(f"plant.{a}", f"plant.{b}") for a, b in WIRES]
    flat = join("Flat", parts, [*wires, SPEED])
    assert [s.name for s in nested.scalars()] == [s.name for s in flat.scalars()]
    p, u = nested.start_values({"plant.motor.torque": 2.0})
    d = nested.settled(p)
    x = nested.states_at_start(u, d)
    np.testing.assert_array_equal(nested.rates_of(x, u, d, 5.0), flat.rates_of(x, u, d, 5.0))


def test_a_vector_of_which_some_elements_are_fed_leaves_the_others_as_inputs() -> None:
    system = join("Read", {"plant": plant(), "sensors": SENSORS}, [READ])
    assert "sensors.temperature[3]" not in system.u.index
    assert {"sensors.temperature[2]", "sensors.temperature[4]"} <= set(system.u.names)
    p, u = system.start_values({"plant.link.initial_temperature": 310.0, "sensors.temperature[4]": 320.0})
    x = system.states_at_start(u, system.settled(p))
    readings = [x[system.x.index[f"sensors.reading[{i}]"]] for i in (3, 4)]
    assert readings == pytest.approx([310.0, 320.0])


def test_sampled_parts_are_sampled_in_the_order_of_data_flow() -> None:
    wires = [READ, ("sensors.reading[3]", "law.base_temperature"), ("law.correction", "camera.correction")]
    for order in (("law", "camera", "sensors"), ("camera", "sensors", "law")):
        parts = {key: {"law": LAG, "camera": CAMERA, "sensors": SENSORS}[key] for key in order}
        system = join("Cell", {**parts, "plant": plant()}, wires)
        assert [c.sample_time for c in system.clocks] == [
            "sensors.sample_time",
            "law.sample_time",
            "camera.sample_time",
        ]


def test_signals_that_jump_are_held_within_a_micro_step() -> None:
    """Seen from the end of a micro step, the duty is still that of its beginning."""
    system = join("Driven", {"duty": DUTY, "plant": plant()}, [SPEED])
    p, u = system.start_values(
        {"duty.duration[1]": 10.0, "duty.duration[2]": 10.0, "duty.segment_speed[2]": 0.0}
    )
    d = system.settled(p)
    x = system.states_at_start(u, d)
    shaft = system.continuous.index["plant.motor.shaft_temperature"]
    before, after = system.rates_of(x, u, d, 9.0)[shaft], system.rates_of(x, u, d, 10.0)[shaft]
    assert before > 0 == after
    assert system.rates_of(x, u, d, 10.0, held_at=9.0)[shaft] == before


def test_checks_speak_of_the_part() -> None:
    p, _ = plant().start_values({"link.tip_position": 0.4})
    assert list(limits.problems(plant(), "cell", p.tolist())) == [
        "cell.link.tip_position: 0.4 m lies beyond the link's end; keep it within length (0.3302 m)"
    ]


def gain(name: str, through: bool) -> Component:
    """Twice its input, at once or by way of a state."""

    def observe(x: Record, u: Record, p: Record, time: Number) -> Mapping[str, Number]:
        return {"y": 2 * u.u if through else x.x}

    return Component(
        name=name,
        description=name,
        observe=observe,
        inputs=(Input("u", "W", "in"), Input("other", "W", "in")),
        outputs=(Output("y", "W", "out"),),
        parameters=(Parameter("k", "1", 1.0, "unused"),),
        states=() if through else (State("x", "W", start=3.0),),
        rates=None if through else (lambda x, u, p, time: {"x": u.u}),
    )


RING = [("a.y", "b.u"), ("b.y", "c.u"), ("c.y", "a.u")]


def test_an_algebraic_loop_is_refused_and_named() -> None:
    ring = {key: gain("Through", True) for key in "abc"}
    with pytest.raises(InputError, match=r"a\.y <- c\.y <- b\.y <- a\.y: .*algebraic loop"):
        join("Ring", ring, RING)


def test_a_loop_with_a_memory_is_none() -> None:
    ring = {"a": gain("Memory", False), "b": gain("Through", True), "c": gain("Through", True)}
    system = join("Ring", ring, RING)
    p, u = system.start_values()
    assert system.rates_of(np.array([3.0]), u, p, 0.0) == pytest.approx([12.0])
    assert dict(zip(system.y.names, system.outputs_of(np.array([3.0]), u, p, 0.0), strict=True)) == {
        "a.y": 3.0,
        "b.y": 6.0,
        "c.y": 12.0,
    }


@pytest.mark.parametrize(
    ("wires", "sentence"),
    [
        ([("a.y", "b.v")], "Ring, wire a.y -> b.v: b.v is no input of its parts"),
        ([("a.u", "b.u")], "Ring, wire a.u -> b.u: a.u is no output of its parts"),
        ([("a.y", "b.u"), ("b.y", "b.u")], "b.u is fed by a.y already; leave one out"),
        ([("d.link.elongation", "b.u")], "m does not fit W; connect equal units"),
        (
            [("d.link.sensor_temperature", "b.u")],
            "d.link.sensor_temperature is a vector; connect its elements, as d.link.sensor_temperature[1]",
        ),
    ],
)
def test_wires_that_do_not_fit_are_refused(wires: list[tuple[str, str]], sentence: str) -> None:
    with pytest.raises(InputError, match=re.escape(sentence)):
        join("Ring", {"a": gain("A", False), "b": gain("B", False), "d": plant()}, wires)


def test_nothing_is_not_joined() -> None:
    with pytest.raises(InputError, match="Ring: has no parts; give one or more to join"):
        join("Ring", {})


def test_two_parts_of_one_name_are_refused() -> None:
    inner = join("Inner", {"b": gain("B", False)})
    with pytest.raises(InputError, match=re.escape("Ring: two parts are called a.b")):
        join("Ring", {"a.b": gain("A", False), "a": inner})


def test_what_was_set_of_a_joined_part_holds_in_the_whole() -> None:
    inner = replace(plant(), default_stop_time=99.0, default_step_size=0.5, micro_step=0.25)
    whole = join("Whole", {"inner": inner})
    assert (whole.default_stop_time, whole.default_step_size, whole.micro_step) == (99.0, 0.5, 0.25)
