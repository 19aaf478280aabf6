"""Process that makes the checks which load the FMU; what it found goes to a file, a line at a time.

python -m warmlink.fmus.packaging.inspection.worker FOLDER RESULTS CHECK...
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main(folder: Path, results: Path, names: list[str]) -> None:
    """Make checks by name; each begins and ends with a line in the file of results."""
    from fmpy import read_model_description

    from warmlink.fmus.packaging.inspection.cases import CASES
    from warmlink.fmus.packaging.inspection.subject import Subject

    description = read_model_description(str(folder), validate=False)
    with results.open("a", encoding="utf-8") as stream:
        for name in names:
            print(json.dumps([name]), file=stream, flush=True)
            try:
                verdict, detail = CASES[name](Subject(description, folder))
            except Exception as error:
                verdict, detail = "fail", f"{type(error).__name__}: {error}".splitlines()[0]
            print(json.dumps([name, verdict, detail]), file=stream, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
