"""A headless browser that opens a page from disk."""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def browse(page: Path, script: str, folder: Path, *, width: int = 1100) -> Any:
    """What a script's `result` is, as JSON, once the page has begun; it finds the page's `model`.

    The page is opened without a network.
    """
    found = [path for name in BROWSERS if (path := shutil.which(name))]
    if not found:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} is installed")
    tried_script = (
        f"const result = await (async () => {{ {script}\nreturn result; }})().catch((fault) => fault.stack);"
    )
    tail = """
        const told = document.createElement("pre");
        told.id = "told";
        told.textContent = JSON.stringify(result);
        document.body.append(told);
    """
    text = page.read_text("utf-8")
    assert text.count("\nbegin();\n") == 1
    tried = folder / f"tried-{page.name}"
    tried.write_text(
        text.replace("\nbegin();\n", f"\nconst model = await begin();\n{tried_script}{tail}\n"), "utf-8"
    )
    command = [
        found[0],
        *("--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},1500"),
        *("--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=60000", "--dump-dom"),
        *(f"--user-data-dir={folder / 'profile'}", tried.as_uri()),
    ]
    dump = subprocess.run(command, capture_output=True, text=True, timeout=240).stdout
    outcome = re.search(r'<pre id="told">(.*?)</pre>', dump, re.DOTALL)
    assert outcome is not None, dump[-2000:]
    return json.loads(unescape(outcome[1]))
