"""The page's modules, run by node."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import warmlink.orchestration.report.live as live

PAGE = Path(live.__file__).parent


def node(script: str, given: Any = None) -> Any:
    """What a script's `result` is, as JSON; it finds `given` and may import from `${page}`."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    head = f"const given = {json.dumps(given)};\n"
    text = head + script.replace("${page}", PAGE.as_uri()) + "\nconsole.log(JSON.stringify(result));"
    done = subprocess.run(["node", "--input-type=module"], input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
