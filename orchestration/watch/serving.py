"""The page of a watch over HTTP, read only: two files of its folder, and nothing else."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.orchestration.console import remark

FILES = {
    "/": ("watch.html", "text/html; charset=utf-8"),
    "/alarms.jsonl": ("alarms.jsonl", "application/x-ndjson"),
}
"""File and its type by path; the state is not among them."""


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
