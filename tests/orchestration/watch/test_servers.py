"""A log through a broker is the same rows as in a file, and a source survives lost connections."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.watch import HEADERS
from tests.orchestration.watch.conftest import ROWS, free_port, read
from warmlink.orchestration.watch.sources.opening import opened
from warmlink.orchestration.watch.sources.served import ServedSource


@contextmanager
def broker(folder: Path, port: int) -> Iterator[subprocess.Popen[bytes]]:
    """A mosquitto of our own, or the test is skipped."""
    program = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")
    if program is None:
        pytest.skip("mosquitto is not installed")
    settings = folder / "mosquitto.conf"
    settings.write_text(
        f"listener {port} 127.0.0.1\nallow_anonymous true\npersistence true\n"
        f"persistence_location {folder}/\nautosave_interval 1\nmax_queued_messages 0\n"
        f"user {os.environ.get('USER', 'root')}\n"
    )
    running = subprocess.Popen(
        [program, "-c", settings], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL
    )
    try:
        for _ in range(200):
            with socket.socket() as tried:
                if tried.connect_ex(("127.0.0.1", port)) == 0:
                    break
            time.sleep(0.02)
        yield running
    finally:
        running.terminate()
        running.wait()


def published(port: int, rows: list[dict[str, Any]]) -> None:
    """Publish rows, each a message."""
    aiomqtt = pytest.importorskip("aiomqtt", reason="aiomqtt is not installed")

    async def publish() -> None:
        async with aiomqtt.Client("127.0.0.1", port) as client:
            for row in rows:
                await client.publish("cell/joint", json.dumps(row), qos=1)

    asyncio.run(publish())


def test_mqtt_with_a_mapping(table: np.ndarray, expected: list[str], tmp_path: Path) -> None:
    pytest.importorskip("aiomqtt", reason="aiomqtt is not installed")
    mapping = tmp_path / "mapping.toml"
    lines = [f'"{header}" = "cell.v{i}"' for i, header in enumerate(HEADERS)]
    mapping.write_text("[columns]\n" + "\n".join(lines) + "\n")
    rows = [{"cell": {f"v{i}": v for i, v in enumerate(row)}, "more": [1]} for row in table[:ROWS].tolist()]
    port = free_port()
    with broker(tmp_path, port):
        source = opened(f"mqtt://127.0.0.1:{port}/cell/joint", follow=True, mapping=mapping)
        published(port, [*rows[:20], *rows[20:]])
        assert read(source) == expected


def test_mqtt_by_its_own_names_and_over_a_broker_that_is_gone_for_a_while(
    table: np.ndarray, expected: list[str], tmp_path: Path
) -> None:
    """The broker keeps what comes while nobody listens, and the source comes back to it by itself."""
    pytest.importorskip("aiomqtt", reason="aiomqtt is not installed")
    rows = [dict(zip(HEADERS, row, strict=True)) for row in table[:ROWS].tolist()]
    port, found = free_port(), list[Any]()
    with broker(tmp_path, port):
        waiting = threading.Thread(
            target=lambda: found.append(opened(f"mqtt://127.0.0.1:{port}/cell/joint", True))
        )
        waiting.start()
        time.sleep(0.3)
        published(port, rows[:1])
        waiting.join()
        published(port, rows[1:10])
        time.sleep(0.2)
    with broker(tmp_path, port):
        time.sleep(1.5)
        published(port, rows[10:])
        assert read(found[0]) == expected
    assert any("lost" in each for each in found[0].told)
    assert any("connected again" in each for each in found[0].told)


class FailingSource(ServedSource):
    """A server that gives a row and is gone, again and again."""

    headers = HEADERS

    def __init__(self, rows: list[list[float]]) -> None:
        super().__init__("server")
        self._left = iter(rows)
        self.begin()

    async def listen(self) -> None:
        """Give a row, and lose the connection."""
        self.stands()
        if (row := next(self._left, None)) is not None:
            self.put(row)
        raise ConnectionResetError("the server is gone")


def test_a_thousand_disconnections(table: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warmlink.orchestration.watch.sources.served._AGAIN", (0.0, 0.0))
    rows = [[float(k), *table[0, 1:].tolist()] for k in range(1000)]
    source = FailingSource(rows)
    found = []
    for cells in source.rows():
        if cells is not None:
            found.append(cells)
        if len(found) == len(rows):
            break
    source.close()
    assert found == rows
    assert 2 < len(source.told) <= 100, "what is told is bounded, whoever listens"
