"""Rows from OPC UA: nodes that are read again and again, by their identifiers or by browse names.

Names are those along the way from the objects, as the companion specification for robotics (OPC 40010-1) has
them: `Motor_1/MotorTemperature` finds the node wherever the motor hangs. Nodes are read, never written.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.fmus.names import listed
from warmlink.orchestration.scenarios.logged.layout import name_and_unit, plain
from warmlink.orchestration.watch.sources.served import ServedSource

PERIOD = 0.5
"""s between two readings."""

_DEEPEST, _MOST_NODES = 12, 20_000
"""Steps from the objects, and nodes, within which names are sought."""

_IDENTIFIERS = ("ns=", "i=", "s=", "g=", "b=", "nsu=")


class OpcuaSource(ServedSource):
    """Nodes of one server.

    Parameters
    ----------
    address : `opc.tcp://host:port`
    columns : node by header: an identifier as `ns=2;s=Tip`, or browse names as `Motor_1/MotorTemperature`.
        Without a header of times a row has the newest time stamp of its values.

    Raises
    ------
    InputError
        Nobody answers there, no columns are given, or a node is not found.
    """

    def __init__(self, address: str, columns: Mapping[str, str]) -> None:
        try:
            import asyncua
        except ImportError:
            raise MissingExtraError("watching over OPC UA", "watch") from None
        if not columns:
            say = argument("mapping", Path("nodes.toml"))
            raise InputError(f"{address}: nothing says which nodes are meant; name them in a file, {say}")
        super().__init__(address)
        self._asyncua, self._columns = asyncua, dict(columns)
        self._timed = any(plain(name_and_unit(header)[0]) == "time" for header in columns)
        self.headers = [*columns] if self._timed else ["time", *columns]
        self._newest: object = None
        self.begin()

    async def listen(self) -> None:
        """Read the nodes while the connection stands."""
        ua = self._asyncua.ua
        async with self._asyncua.Client(self.name, timeout=5.0) as client:
            nodes = await self._nodes(client)
            self.stands()
            while not self.is_over:
                values = await client.read_attributes(nodes, ua.AttributeIds.Value)
                self._take(values)
                await asyncio.sleep(PERIOD)

    def _take(self, values: list[Any]) -> None:
        """A row of what was read, unless it is the one before."""
        cells = [_cell(each) for each in values]
        stamps = [each.SourceTimestamp for each in values if each.SourceTimestamp is not None]
        if not self._timed:
            cells.insert(0, max(stamps).isoformat() if stamps else None)
        now = cells[self._time]
        if now is not None and now != self._newest:
            self._newest = now
            self.put(cells)

    @property
    def _time(self) -> int:
        return [plain(name_and_unit(header)[0]) == "time" for header in self.headers].index(True)

    async def _nodes(self, client: Any) -> list[Any]:
        """Nodes of the columns; raises InputError where there is none of a name, or several."""
        names = [*self._columns.values()]
        called = {each: each.strip("/").split("/") for each in names if not each.startswith(_IDENTIFIERS)}
        found: dict[str, dict[tuple[str, ...], Any]] = {each: {} for each in called}
        if called:  # once for all of them: a robot has thousands of nodes
            async for way, node in _below(client.nodes.objects, self._asyncua.ua):
                for name, wanted in called.items():
                    if _leads(way, wanted):
                        found[name][way] = node
        return [
            self._only(each, found[each]) if each in called else await self._identified(client, each)
            for each in names
        ]

    async def _identified(self, client: Any, name: str) -> Any:
        """Node of an identifier; raises InputError where there is none."""
        try:
            node = client.get_node(name)
            await node.read_browse_name()
        except (self._asyncua.ua.UaError, ValueError) as fault:
            raise InputError(f"{self.name}: there is no node {name} ({fault}); correct the mapping") from None
        return node

    def _only(self, name: str, found: Mapping[tuple[str, ...], Any]) -> Any:
        """The one node that browse names lead to; raises InputError where there is none, or several."""
        if len(found) != 1:
            several = listed(["/".join(way) for way in found][:4])
            told = (
                f"several nodes are called so: {several}; name more of the way"
                if found
                else "no node is called so"
            )
            raise InputError(f"{self.name}: {name}: {told}; browse the server, and correct the mapping")
        return next(iter(found.values()))


async def _below(root: Any, ua: Any) -> Any:
    """Variables below a node with the names that lead to them."""
    waiting: list[tuple[tuple[str, ...], Any]] = [((), root)]
    seen = set[Any]()
    while waiting and len(seen) < _MOST_NODES:
        way, node = waiting.pop()
        for each in await node.get_children_descriptions():
            if each.NodeId in seen or (not way and each.BrowseName.Name == "Server"):
                continue
            seen.add(each.NodeId)
            below = (*way, each.BrowseName.Name)
            child = type(root)(root.session, each.NodeId)
            if each.NodeClass == ua.NodeClass.Variable:
                yield below, child
            if len(below) < _DEEPEST:
                waiting.append((below, child))


def _leads(way: tuple[str, ...], wanted: list[str]) -> bool:
    """Whether the wanted names come along a way in their order, the last at its end."""
    steps: Iterator[str] = iter(way)
    return bool(way) and way[-1] == wanted[-1] and all(each in steps for each in wanted)


def _cell(value: Any) -> str | float | None:
    """A value as a cell; None where its status is bad."""
    if value.StatusCode is not None and not value.StatusCode.is_good():
        return None
    held: Any = value.Value.Value if value.Value is not None else None
    if isinstance(held, bool):
        return float(held)
    if isinstance(held, int | float | str):
        return held
    return held.isoformat() if hasattr(held, "isoformat") else None
