"""What tests ask of a browser: to open a page from disk, without a network, and to say what it finds."""

import os
import shutil
import subprocess
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, Self

import pytest

HIGH = 1500
"""Pixels of a window's height."""

LAST = "\nrestore(location.hash);\n"
"""What the page's module does last."""

CALL = (
    "(async () => {{ while (!globalThis.tried) await new Promise((go) => setTimeout(go, 20)); {} }})()"
    ".then((value) => ({{ value }}), (fault) => ({{ fault: `${{fault}} ${{fault.stack}}` }}))"
)


class Browser(ABC):
    """A headless browser with one tab; a subclass speaks the browser's own protocol."""

    commands: ClassVar[tuple[str, ...]]

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def found(cls) -> str:
        """Path of the browser; without one the test is skipped."""
        for name in cls.commands:
            if path := shutil.which(name):
                return path
        pytest.skip(f"none of {', '.join(cls.commands)} is installed")

    @classmethod
    @contextmanager
    @abstractmethod
    def started(cls, folder: Path) -> Iterator[Self]:
        """A browser that keeps its profile in a folder, and ends with the context."""

    @abstractmethod
    def open(self, page: Path, width: int = 1100, scheme: str = "light") -> None:
        """Open a page so wide [pixels], in light or dark."""

    @abstractmethod
    def evaluate(self, expression: str) -> Any:
        """What a promise comes to, as JSON."""

    @abstractmethod
    def press_right(self) -> None:
        """Press the right arrow key."""

    @abstractmethod
    def picture(self) -> bytes:
        """The whole page as PNG."""

    def value(self, body: str) -> Any:
        """What the body of an asynchronous function returns, once the page has begun."""
        answer = self.evaluate(CALL.format(body))
        assert "fault" not in answer, answer["fault"]
        return answer.get("value")

    def browse(self, page: Path, script: str) -> Any:
        """What a script's `result` is; it is part of the page's module and finds its functions."""
        text = page.read_text("utf-8")
        assert text.count(LAST) == 1
        tried = self.folder / f"tried-{page.name}"
        body = f"globalThis.tried = async () => {{ {script}\nreturn result; }};"
        tried.write_text(text.replace(LAST, f"{LAST}{body}\n"), "utf-8")
        self.open(tried)
        return self.value("return await tried();")


def violations(browser: Browser) -> list[list[str]]:
    """What axe, an accessibility checker, finds on the open page: rule and first element of each."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    asked = ["node", "-p", "require.resolve('axe-core/axe.min.js')"]
    place = subprocess.run(asked, capture_output=True, text=True, env=os.environ).stdout.strip()
    if not place:
        pytest.skip("axe-core is not found by node: npm install axe-core, and name its folder in NODE_PATH")
    browser.value(Path(place).read_text("utf-8"))
    found: list[list[str]] = browser.value(
        "return (await axe.run()).violations.map((each) => [each.id, each.nodes[0].html]);"
    )
    return found
