"""The page of a watch: one file that renews itself, and that may be served over HTTP, read only."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.arrays import Array
from warmlink.orchestration.console import remark
from warmlink.orchestration.files import fresh_file
from warmlink.orchestration.report.page import rendered
from warmlink.orchestration.system.units import ZERO_CELSIUS
from warmlink.orchestration.watch.diagnosing import said_of
from warmlink.orchestration.watch.watcher import SHOWN
from warmlink.orchestration.watch.watching import ALARMS, Watching

PAGE = "watch.html"

FILES = {
    "/": (PAGE, "text/html; charset=utf-8"),
    "/alarms.jsonl": (ALARMS, "application/x-ndjson"),
}
"""File and its type by path; the state is not among them."""

_SECONDS = 10
"""s after which the page loads itself anew."""

_MOST_ALARMS, _HOUR = 20, 3600.0
"""Alarms that are listed, and s of the log that readings are shown of."""

_EPOCH = 1e9
"""s from which on times count since 1970."""

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 420, 190, 50, 6, 10, 26


class Plot(NamedTuple):
    """A plot as the template draws it."""

    heading: str
    text: str
    ticks: Sequence[tuple[float, str]]
    lines: Sequence[tuple[str, str]]
    first: str
    last: str
    limit: float | None = None
    band: str = ""
    width: int = _WIDTH
    height: int = _HEIGHT


def write_watch(watching: Watching) -> None:
    """Write the page of a watch into its folder, whole or as it was."""
    with fresh_file(watching.folder / PAGE) as scratch:
        scratch.write_text(page_of(watching), "utf-8")


def page_of(watching: Watching) -> str:
    """HTML of a watch as it stands."""
    watcher = watching.watcher
    levels = [{"name": name, "level": level} for name, level in watcher.by_verdict().items()]
    alarms = [
        {
            "when": when(first["time_s"]),
            "verdict": last["verdict"],
            "told": last["told"],
            "diagnosed": _diagnosed(watching, first),
        }
        for first, last in zip(watching.alarms, _last_names(watching), strict=True)
    ]
    return rendered(
        "watch.html.j2",
        title=f"Watching {watching.source.name}",
        kind="watch",
        lead=lead(watching),
        levels=levels,
        alarms=alarms[::-1][:_MOST_ALARMS],
        plots=_plots(watching) if len(watcher.moments) > 1 else [],
        read=f"{watching.rows} rows of {watching.source.name}, judged {watcher.machine.tick:g} s at a time.",
        remarks=watching.remarks(),
        seconds=_SECONDS,
    )


def _diagnosed(watching: Watching, alarm: dict[str, Any]) -> str:
    """What a diagnosis said of an alarm, in a line; nothing before it has."""
    files = alarm.get("offered", [])
    return said_of(watching.folder / Path(files[0]).parent) if files else ""


def _last_names(watching: Watching) -> list[dict[str, Any]]:
    """What was told last of each alarm: with more rows its name is surer."""
    found: list[dict[str, Any]] = []
    for event in watching.events:
        if event["alarm"] and "again" in event and found:
            found[-1] = event
        elif event["alarm"]:
            found.append(event)
    return found


def lead(watching: Watching) -> str:
    """How it stands, in a sentence or two."""
    watcher = watching.watcher
    if watcher.limits is None:
        hours = (watcher.opening[-1].end - watcher.opening[0].start) / 3600 if watcher.opening else 0.0
        return f"Learning: {hours:.1f} h of the {watcher.sound / 3600:.4g} h declared sound have come in."
    last = f"Last row judged at {when(watcher.moments[-1].time)}; {watcher.limits.told()}."
    if watcher.law is not None and np.isfinite(watcher.law.last):
        ready = {None: "", True: "; it says it is ready", False: "; it says it is not ready"}
        last += f" The law leaves {1e6 * watcher.law.last:.1f} um{ready[watcher.law.ready]}."
    if watcher.standing is not None:
        names = " or ".join(watcher.standing.causes) or "no known cause"
        return f"ALARM since {when(watcher.standing.time)}: {names}. {last}"
    if watching.alarms:
        return f"No alarm now; what was found before stands below, and may be there still. {last}"
    return f"All is as in the sound part. {last}"


def when(time: float) -> str:
    """A time of the log as people read it."""
    if time >= _EPOCH:
        return datetime.fromtimestamp(time, UTC).strftime("%d %b %H:%M UTC")
    return f"{time / 3600:.2f} h"


def _plots(watching: Watching) -> list[Plot]:
    watcher, found = watching.watcher, []
    time = np.array([each.time for each in watcher.moments])
    level = np.array([max(each.levels.values()) for each in watcher.moments])
    shown = np.minimum(level, 2.5)
    found.append(
        _plot(
            "Evidence",
            "Largest sum as a share of its threshold (dashed: alarm)",
            time,
            [("line", shown)],
            limit=1.0,
        )
    )
    names, rig = watcher.machine.names, watcher.machine.rig
    since = watcher.moments[-1].time - _HOUR
    last = [each for each in watcher.moments if each.time > since][-SHOWN:]
    span = (last[-1].time - last[0].time) / 60
    time = np.array([each.time for each in last])
    for i, output in enumerate(watcher.machine.outputs):
        kelvin = rig.unit(output) == "K"
        scale, shift, unit = (1.0, ZERO_CELSIUS, "degC") if kelvin else (1e6, 0.0, "um")
        read, expected, sigma = (
            np.array([getattr(each, name)[i] for each in last]) for name in ("readings", "expected", "sigma")
        )
        band = np.nan_to_num(3 * sigma) * scale
        read, expected = scale * (read - shift), scale * (expected - shift)
        text = f"Last {span:.0f} min in {unit}: read (red) and expected (blue, with 3 sigma)"
        lines = [("line", expected), ("read", read)]
        found.append(_plot(names[output], text, time, lines, band=(expected - band, expected + band)))
    return found


def _plot(
    heading: str,
    text: str,
    time: Array,
    lines: Sequence[tuple[str, Array]],
    limit: float | None = None,
    band: tuple[Array, Array] | None = None,
) -> Plot:
    """A plot of courses over time, scaled to what they hold."""
    every = np.concatenate(
        [each for _, each in lines] + list(band or ()) + [np.array([0.0, limit or 0.0])] * bool(limit)
    )
    low, high = float(np.nanmin(every)), float(np.nanmax(every))
    low, high = (low, high) if high - low > 1e-9 else (low - 1, high + 1)
    x = _LEFT + (time - time[0]) / max(time[-1] - time[0], 1e-9) * (_WIDTH - _LEFT - _RIGHT)

    def y(values: Any) -> Any:
        return _TOP + (high - values) / (high - low) * (_HEIGHT - _TOP - _BOTTOM)

    drawn = [(kind, _points(x, y(values))) for kind, values in lines]
    step = 10 ** np.floor(np.log10((high - low) / 2))
    step *= next(each for each in (5, 2, 1) if (high - low) / (each * step) >= 2)
    places = max(0, -int(np.floor(np.log10(step))))
    rounds = step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
    marks = [(round(float(y(v)), 1), f"{v:.{places}f}") for v in rounds.tolist()]
    outline = ""
    if band is not None:
        outline = _points(np.append(x, x[::-1]), y(np.append(band[0], band[1][::-1])))
    at = None if limit is None else round(float(y(limit)), 1)
    return Plot(heading, text, marks, drawn, when(time[0]), when(time[-1]), at, outline)


def _points(x: Array, y: Array) -> str:
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True) if np.isfinite(b))


@contextmanager
def served(address: str, folder: Path) -> Iterator[int]:
    """Serve the page meanwhile, at the address that was given and no other; gives the port.

    Parameters
    ----------
    address : HOST:PORT; a loopback host unless others are to see it
    folder : of the watch

    Raises
    ------
    InputError
        The address is none, or is taken.
    """
    host, colon, port = address.rpartition(":")
    where = argument("serve", address)
    if not (colon and host and port.isdigit() and int(port) < 65536):
        raise InputError(f"{where}: is no address; write HOST:PORT, as 127.0.0.1:8080")

    class Handler(BaseHTTPRequestHandler):
        """Gives the files to whoever asks, and takes nothing."""

        def do_GET(self) -> None:
            """Answer with a file, or that there is none."""
            found = FILES.get(self.path.partition("?")[0])
            try:
                content = (folder / found[0]).read_bytes() if found else None
            except OSError:
                content = None
            self.send_response(404 if content is None else 200)
            self.send_header("Content-Type", found[1] if found else "text/plain")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(b"nothing here\n" if content is None else content)

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing of each request."""

    try:
        server = ThreadingHTTPServer((host, int(port)), Handler)
    except OSError as fault:
        raise InputError(
            f"{where}: cannot be served ({fault.strerror or fault}); choose another address"
        ) from None
    thread = threading.Thread(target=server.serve_forever, name="page", daemon=True)
    thread.start()
    remark(f"the page is at http://{host}:{server.server_port}/")
    try:
        yield server.server_port
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
