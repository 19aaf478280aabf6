"""Commands in copies of a process that has imported what they need: they do as others, but begin sooner."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from pathlib import Path

# The first command tells which modules it needed; those after it find them imported.
_COPIED = """
import atexit, contextlib, importlib, json, os, shutil, sys, tempfile
from pathlib import Path
from warmlink.orchestration import cli

place = tempfile.mkdtemp()
needed = Path(place, "needed")
print(place, flush=True)
for line in sys.stdin:
    folder, arguments = json.loads(line)
    child = os.fork()
    if not child:
        os.chdir(folder)
        for number, name in enumerate((os.devnull, f"{place}/out", f"{place}/err")):
            os.dup2(os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC), number)
        os.closerange(3, 64)
        sys.argv = ["warmlink", *arguments]
        if not needed.exists():
            atexit.register(lambda: needed.write_text("\\n".join(sys.modules)))
        cli.main()
        sys.exit()
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    for name in needed.read_text().split() if needed.exists() else ():
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    print(code, flush=True)
shutil.rmtree(place)
"""


def ran(*arguments: str) -> subprocess.CompletedProcess[str]:
    """What becomes of `warmlink ARGUMENTS` in the present folder, in a process of its own; POSIX only."""
    process, place = _copied()
    assert process.stdin is not None
    assert process.stdout is not None
    print(json.dumps((str(Path.cwd()), arguments)), file=process.stdin, flush=True)
    code = int(process.stdout.readline())
    out, err = ((place / name).read_text("utf-8") for name in ("out", "err"))
    return subprocess.CompletedProcess(arguments, code, out, err)


@cache
def _copied() -> tuple[subprocess.Popen[str], Path]:
    """The process, which ends with this one as nobody can ask it any more, and the folder that it makes."""
    process = subprocess.Popen(
        [sys.executable, "-c", _COPIED], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())
