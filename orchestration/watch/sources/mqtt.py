"""Rows from MQTT: each message of a topic is a row in JSON; it is listened to, never published."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import urlsplit

from warmlink.fmus.errors import InputError, MissingExtraError
from warmlink.orchestration.watch.sources.served import ServedSource

PASSWORD = "WARMLINK_MQTT_PASSWORD"
"""Environment variable that holds the password, so that it stands in no command line."""

_PORT = 1883
_MOST = 1 << 20
"""Bytes of a message beyond which it is passed over."""


class MqttSource(ServedSource):
    """Messages of one topic.

    The broker keeps messages for a listener that is away (a session that is not clean, quality of service 1).

    Parameters
    ----------
    address : `mqtt://host:port/topic`, perhaps with a user before the host
    columns : path in a message by header, `motor.temperature`; empty: the first message's keys are headers

    Raises
    ------
    InputError
        The address is none, or nobody answers there.
    """

    def __init__(self, address: str, columns: Mapping[str, str]) -> None:
        try:
            import aiomqtt
        except ImportError:
            raise MissingExtraError("watching over MQTT", "watch") from None
        parts = urlsplit(address)
        self._topic = parts.path.lstrip("/")
        if parts.password:
            raise InputError(
                f"mqtt://{parts.hostname}: a password in the address can be read by all; set {PASSWORD}"
            )
        if not (parts.hostname and self._topic):
            raise InputError(f"{address}: names no host or no topic; write mqtt://HOST/TOPIC")
        super().__init__(address)
        self._aiomqtt, self._host, self._user = aiomqtt, parts.hostname, parts.username
        self._port = parts.port or _PORT
        self._columns = dict(columns)
        self.headers: Sequence[str] = list(columns)
        self.begin()

    async def listen(self) -> None:
        """Take messages while the connection stands."""
        async with self._aiomqtt.Client(
            self._host,
            self._port,
            identifier=f"warmlink-{hashlib.sha256(self.name.encode()).hexdigest()[:12]}",
            clean_session=False,
            username=self._user,
            password=os.environ.get(PASSWORD),
        ) as client:
            await client.subscribe(self._topic, qos=1)
            if self.headers:
                self.stands()
            messages = aiter(client.messages)
            waiting: asyncio.Future[Any] | None = None
            while not self.is_over:
                waiting = waiting or asyncio.ensure_future(anext(messages))
                done, _ = await asyncio.wait([waiting], timeout=0.2)
                if done:
                    self._take(waiting.result().payload)
                    waiting = None
            if waiting is not None:
                waiting.cancel()

    def _take(self, payload: object) -> None:
        """Make a row of a message; one that is no JSON object is passed over, and told of."""
        try:
            if not isinstance(payload, bytes | bytearray) or len(payload) > _MOST:
                raise ValueError
            found = json.loads(payload)
            said = _flat(found)
        except (ValueError, AttributeError, RecursionError):
            self.tell(f"{self.name}: a message is no JSON object and was passed over")
            return
        if not self.headers:
            self.headers = list(said)
            self._columns = {name: name for name in said}
            self.stands()
        self.put([_cell(said.get(path)) for path in self._columns.values()])


def _flat(found: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Values by path."""
    said: dict[str, Any] = {}
    for name, value in found.items():
        said |= _flat(value, f"{before}{name}.") if isinstance(value, dict) else {f"{before}{name}": value}
    return said


def _cell(value: Any) -> str | float | None:
    if isinstance(value, bool):
        return float(value)
    return value if isinstance(value, str | int | float) else None
