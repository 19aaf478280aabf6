"""Chromium, driven by the DevTools protocol over a pipe."""

import base64
import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from tests.browser import HIGH, Browser

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run")
NO_NETWORK = "--host-resolver-rules=MAP * ~NOTFOUND"


class Chromium(Browser):
    """Calls go out and answers come in as JSON, each ended by a zero byte."""

    commands = ("chromium", "chromium-browser", "google-chrome")

    def __init__(self, folder: Path, out: int, into: int) -> None:
        super().__init__(folder)
        self.out, self.into, self.read, self.calls = out, os.fdopen(into, "rb", 0), b"", 0
        self.session: dict[str, str] = {}
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self.session = {"sessionId": attached["sessionId"]}

    @classmethod
    @contextmanager
    def started(cls, folder: Path) -> Iterator[Self]:
        program = cls.found()
        theirs, out = os.pipe()
        into, their_out = os.pipe()

        def given() -> None:
            # Whatever numbers they have, also if one of them is 3 or 4.
            ends = [os.dup(theirs), os.dup(their_out)]
            for number, end in zip((3, 4), ends, strict=True):
                os.dup2(end, number)

        command = [program, *FLAGS, NO_NETWORK, f"--user-data-dir={folder / 'profile'}"]
        quiet = subprocess.DEVNULL
        with subprocess.Popen(
            command, preexec_fn=given, close_fds=False, stdout=quiet, stderr=quiet
        ) as process:
            os.close(theirs)
            os.close(their_out)
            try:
                yield cls(folder, out, into)
            finally:
                process.kill()
                os.close(out)

    def call(self, method: str, **parameters: Any) -> Any:
        self.calls += 1
        message = {"id": self.calls, "method": method, "params": parameters, **self.session}
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.read:
                self.read += self.into.read(1 << 16)
            line, _, self.read = self.read.partition(b"\0")
            answer = json.loads(line)
            if answer.get("id") == self.calls:
                return answer["result"]

    def open(self, page: Path, width: int = 1100, scheme: str = "light") -> None:
        size = {"width": width, "height": HIGH, "deviceScaleFactor": 1, "mobile": width < 500}
        self.call("Emulation.setDeviceMetricsOverride", **size)
        media = [{"name": "prefers-color-scheme", "value": scheme}]
        self.call("Emulation.setEmulatedMedia", features=media)
        self.call("Page.navigate", url=page.as_uri())

    def evaluate(self, expression: str) -> Any:
        given = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in given, given["exceptionDetails"]["exception"]["description"]
        return given["result"]["value"]

    def press_right(self) -> None:
        key = {"key": "ArrowRight", "code": "ArrowRight", "windowsVirtualKeyCode": 39}
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, **key)

    def picture(self) -> bytes:
        return base64.b64decode(self.call("Page.captureScreenshot", captureBeyondViewport=True)["data"])
