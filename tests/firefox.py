"""Firefox, driven by Marionette over a socket."""

import base64
import json
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from tests.browser import HIGH, Browser

FLAGS = ("--headless", "--no-remote", "--marionette", "--remote-allow-system-access")
PREFERENCES = {
    "marionette.port": 0,
    # Every request goes to a proxy that nobody is.
    "network.proxy.type": 1,
    "network.proxy.socks": "127.0.0.1",
    "network.proxy.socks_port": 9,
    "network.proxy.socks_remote_dns": True,
    "network.proxy.allow_hijacking_localhost": True,
}
WIDEST = 2000
PATIENCE = 60
"""Seconds that Firefox may take to start, or to answer."""

RIGHT_ARROW = "\ue014"
# The window itself cannot be as narrow as a telephone; what is in it can.
SIZE = "gBrowser.selectedBrowser.style.cssText = `min-width: 0; width: ${arguments[0]}px`;"
SCHEME = "Services.prefs.setIntPref('layout.css.prefers-color-scheme.content-override', arguments[1]);"
SCHEMES = {"dark": 0, "light": 1}


class Firefox(Browser):
    """Calls go out and answers come in as JSON, each after its length and a colon."""

    commands = ("firefox-esr", "firefox")

    def __init__(self, folder: Path, port: int) -> None:
        super().__init__(folder)
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self.stream = self.socket.makefile("rb")
        self.calls = 0
        self.answer()  # a greeting
        self.call("WebDriver:NewSession")
        self.call("WebDriver:SetTimeouts", script=1000 * PATIENCE, pageLoad=1000 * PATIENCE)
        self.call("WebDriver:SetWindowRect", width=WIDEST, height=HIGH)

    @classmethod
    @contextmanager
    def started(cls, folder: Path) -> Iterator[Self]:
        program, profile = cls.found(), folder / "profile"
        profile.mkdir()
        lines = [
            f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()
        ]
        (profile / "user.js").write_text("\n".join(lines), "utf-8")
        quiet = subprocess.DEVNULL
        with subprocess.Popen(
            [program, *FLAGS, "--profile", str(profile)], stdout=quiet, stderr=quiet
        ) as process:
            try:
                opened = cls(folder, port_of(profile))
                yield opened
                opened.socket.close()
            finally:
                process.kill()

    def answer(self) -> Any:
        length = b""
        while not length.endswith(b":"):
            length += self.stream.read(1)
        return json.loads(self.stream.read(int(length[:-1])))

    def call(self, method: str, **parameters: Any) -> Any:
        self.calls += 1
        message = json.dumps([0, self.calls, method, parameters]).encode()
        self.socket.sendall(b"%d:%b" % (len(message), message))
        _, number, fault, result = self.answer()
        assert number == self.calls
        assert fault is None, fault
        return result

    def open(self, page: Path, width: int = 1100, scheme: str = "light") -> None:
        self.call("Marionette:SetContext", value="chrome")
        self.call("WebDriver:ExecuteScript", script=SIZE + SCHEME, args=[width, SCHEMES[scheme]])
        self.call("Marionette:SetContext", value="content")
        self.call("WebDriver:Navigate", url=page.as_uri())

    def evaluate(self, expression: str) -> Any:
        script = f"{expression}.then(arguments[0]);"
        return self.call("WebDriver:ExecuteAsyncScript", script=script, args=[])["value"]

    def press_right(self) -> None:
        (focused,) = self.call("WebDriver:GetActiveElement")["value"].values()
        self.call("WebDriver:ElementSendKeys", id=focused, text=RIGHT_ARROW)

    def picture(self) -> bytes:
        return base64.b64decode(self.call("WebDriver:TakeScreenshot", full=True)["value"])


def port_of(profile: Path) -> int:
    """Port at which a Firefox that has just been started listens."""
    file = profile / "MarionetteActivePort"
    end = time.monotonic() + PATIENCE
    while not (file.is_file() and file.read_text()):
        assert time.monotonic() < end, f"Firefox does not listen after {PATIENCE} s"
        time.sleep(0.05)
    return int(file.read_text())
