"""A log through an OPC UA server is the same rows as in a file: by node, by name, from a robot."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.watch import HEADERS
from tests.orchestration.watch.conftest import ROWS, free_port, read
from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.data.options import ReadOptions
from warmlink.orchestration.machine.heat_paths import rig_of
from warmlink.orchestration.watch.sources.opcua import OpcuaSource
from warmlink.orchestration.watch.sources.opening import opened
from warmlink.orchestration.watch.sources.rows import RowReader

asyncua = pytest.importorskip("asyncua", reason="asyncua is not installed")

NODESETS = os.environ.get("WARMLINK_ROBOTICS_NODESET", "")
"""Folder that holds `Opc.Ua.Di.NodeSet2.xml` and `Opc.Ua.Robotics.NodeSet2.xml` of the OPC Foundation."""

BEGUN = datetime(2026, 1, 5, 6, 0, tzinfo=UTC)

Places = Callable[[Any], Awaitable[list[Any]]]
"""Lays out a server; its nodes in the order of `HEADERS`."""


@contextmanager
def server_of(places: Places, table: np.ndarray) -> Iterator[str]:
    """Address of a server that shows a row after another, each until it was read."""
    address = f"opc.tcp://127.0.0.1:{free_port()}"
    ready, over, seen = threading.Event(), threading.Event(), list[int]()

    async def serve() -> None:
        server = asyncua.Server()
        await server.init()
        server.set_endpoint(address)
        nodes = await places(server)
        async with server:
            for k, row in enumerate(table[:ROWS].tolist()):
                stamp = BEGUN + timedelta(seconds=row[0])
                for node, value in reversed(list(zip(nodes, row, strict=True))):
                    held = asyncua.ua.Variant(value, asyncua.ua.VariantType.Double)
                    await node.write_value(asyncua.ua.DataValue(held, SourceTimestamp=stamp))
                ready.set()
                while len(seen) <= k and not over.is_set():
                    await asyncio.sleep(0.005)
            while not over.is_set():
                await asyncio.sleep(0.02)

    thread = threading.Thread(target=lambda: asyncio.run(serve()))
    thread.start()
    with pytest.MonkeyPatch.context() as patch:
        take = OpcuaSource.put
        patch.setattr("warmlink.orchestration.watch.sources.opcua.PERIOD", 0.005)
        patch.setattr(OpcuaSource, "put", lambda source, cells: (take(source, cells), seen.append(1)))
        try:
            assert ready.wait(120)
            yield address
        finally:
            over.set()
            thread.join()


def mapping_in(folder: Path, columns: dict[str, str]) -> Path:
    path = folder / "nodes.toml"
    path.write_text("[columns]\n" + "\n".join(f'"{h}" = "{name}"' for h, name in columns.items()))
    return path


async def cell(server: Any) -> list[Any]:
    """A cell of our own, with names as the companion specification for robotics gives them."""
    space = await server.register_namespace("cell")
    robot = await server.nodes.objects.add_object(space, "MotionDeviceSystem")
    motor = await robot.add_object(space, "Motor_1")
    settings = await motor.add_object(space, "ParameterSet")
    return [
        await settings.add_variable(asyncua.ua.NodeId(f"v{i}", space), f"Value{i}", 0.0)
        for i in range(len(HEADERS))
    ]


@pytest.mark.parametrize("name", ["ns=2;s=v{}", "Motor_1/Value{}"])
def test_by_node_and_by_name(name: str, table: np.ndarray, expected: list[str], tmp_path: Path) -> None:
    columns = {header: name.format(i) for i, header in enumerate(HEADERS)}
    with server_of(cell, table) as address:
        assert read(opened(address, follow=True, mapping=mapping_in(tmp_path, columns))) == expected
        wrong = mapping_in(tmp_path, {"base_temperature [degC]": "Motor_9/MotorTemperature"})
        with pytest.raises(InputError, match="no node is called so"):
            opened(address, follow=True, mapping=wrong)


async def robot(server: Any) -> list[Any]:
    """A robot whose types are the official ones, beside it what these do not know: a cell's own readings."""
    for name in ("Di", "Robotics"):
        await server.import_xml(Path(NODESETS) / f"Opc.Ua.{name}.NodeSet2.xml")
    robotics = await server.get_namespace_index("http://opcfoundation.org/UA/Robotics/")
    devices = await server.get_namespace_index("http://opcfoundation.org/UA/DI/")
    space = await server.register_namespace("urn:cell")

    async def made(where: Any, name: str, kind: int) -> Any:
        of = server.get_node(asyncua.ua.NodeId(kind, robotics))
        return await where.add_object(space, name, objecttype=of)

    system = await made(server.nodes.objects, "System", 1002)
    device = await made(await system.get_child(f"{robotics}:MotionDevices"), "MotionDevice_1", 1004)
    axis = await made(await device.get_child(f"{robotics}:Axes"), "Axis_1", 16601)
    train = await made(await device.get_child(f"{robotics}:PowerTrains"), "PowerTrain_1", 16794)
    motor = await made(train, "Motor_1", 1019)
    own = await server.nodes.objects.add_object(space, "Cell")
    nodes = [await own.add_variable(space, header.split(" ")[0], 0.0) for header in HEADERS]
    way = f"{devices}:ParameterSet"
    nodes[HEADERS.index("speed [rad/s]")] = await axis.get_child([way, f"{robotics}:ActualSpeed"])
    nodes[HEADERS.index("shaft_temperature [degC]")] = await motor.get_child(
        [way, f"{robotics}:MotorTemperature"]
    )
    return nodes


@pytest.mark.skipif(
    not NODESETS,
    reason="the official nodesets are not there: give a folder with those of Robotics and DI, from "
    "github.com/OPCFoundation/UA-Nodeset, as WARMLINK_ROBOTICS_NODESET",
)
def test_a_robot_of_the_companion_specification(table: np.ndarray, tmp_path: Path) -> None:
    """By the specification's own names; the time is the newest time stamp of the values."""
    columns = {header: f"Cell/{header.split(' ')[0]}" for header in HEADERS[1:]}
    columns["speed [rad/s]"] = "Axis_1/ActualSpeed"
    columns["shaft_temperature [degC]"] = "Motor_1/MotorTemperature"
    reader = RowReader("table", ["time", *HEADERS[1:]], rig_of("WarmupCell"), ReadOptions())
    stamps = [(BEGUN + timedelta(seconds=at)).replace(tzinfo=None).isoformat() for at in table[:ROWS, 0]]
    expected = [reader.read([at, *row[1:]]) for at, row in zip(stamps, table[:ROWS].tolist(), strict=True)]
    with server_of(robot, table) as address:
        found = read(opened(address, follow=True, mapping=mapping_in(tmp_path, columns)))
    assert found == [repr(each) for each in expected]
