"""A headless browser that opens a page from disk, driven by the DevTools protocol over a pipe."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run")
NO_NETWORK = "--host-resolver-rules=MAP * ~NOTFOUND"

CALL = "(async () => {{ while (!globalThis.tried) await new Promise((go) => setTimeout(go, 20)); {} }})()"


class Tab:
    """One page; calls go out and answers come in as JSON, each ended by a zero byte."""

    def __init__(self, out: int, into: int) -> None:
        self.out, self.into, self.read, self.calls = out, os.fdopen(into, "rb", 0), b"", 0
        self.session: dict[str, str] = {}

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

    def value(self, body: str) -> Any:
        """What the body of an asynchronous function returns, once the page has begun."""
        given = self.call(
            "Runtime.evaluate", expression=CALL.format(body), awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in given, given["exceptionDetails"]["exception"]["description"]
        return given["result"].get("value")


@contextmanager
def tab(page: Path, folder: Path, width: int = 1100, scheme: str = "light") -> Iterator[Tab]:
    """The page opened from disk, so wide [pixels], without a network, in light or dark."""
    found = [path for name in BROWSERS if (path := shutil.which(name))]
    if not found:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    theirs, out = os.pipe()
    into, their_out = os.pipe()

    def given() -> None:
        # Whatever numbers they have, also if one of them is 3 or 4.
        ends = [os.dup(theirs), os.dup(their_out)]
        for number, end in zip((3, 4), ends, strict=True):
            os.dup2(end, number)

    command = [found[0], *FLAGS, NO_NETWORK, f"--user-data-dir={folder / 'profile'}"]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, preexec_fn=given, close_fds=False, stdout=quiet, stderr=quiet) as browser:
        os.close(theirs)
        os.close(their_out)
        try:
            opened = Tab(out, into)
            target = opened.call("Target.createTarget", url="about:blank")["targetId"]
            attached = opened.call("Target.attachToTarget", targetId=target, flatten=True)
            opened.session = {"sessionId": attached["sessionId"]}
            size = {"width": width, "height": 1500, "deviceScaleFactor": 1, "mobile": width < 500}
            opened.call("Emulation.setDeviceMetricsOverride", **size)
            media = [{"name": "prefers-color-scheme", "value": scheme}]
            opened.call("Emulation.setEmulatedMedia", features=media)
            opened.call("Page.navigate", url=page.as_uri())
            yield opened
        finally:
            browser.kill()
            os.close(out)


def browse(page: Path, script: str, folder: Path) -> Any:
    """What a script's `result` is; it is part of the page's module and finds the page's `model`."""
    text = page.read_text("utf-8")
    assert text.count("\nbegin();\n") == 1
    tried = folder / f"tried-{page.name}"
    body = f"globalThis.tried = async () => {{ {script}\nreturn result; }};"
    tried.write_text(text.replace("\nbegin();\n", f"\nconst model = await begin();\n{body}\n"), "utf-8")
    with tab(tried, folder) as opened:
        return opened.value("return await tried();")
