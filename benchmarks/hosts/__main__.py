"""Run one job in this process: `python -m benchmarks.hosts ours:plain '{...}'`."""

from __future__ import annotations

import importlib
import json
import sys
from dataclasses import asdict

from benchmarks.hosts import Job
from warmlink.fmus.errors import InputError

MARK = "FINISHED "
"""Before the answer, for some masters log to standard output."""


def main() -> int:
    """Do the job that the command line describes and print what came of it."""
    module, _, function = sys.argv[1].partition(":")
    job = Job(**json.loads(sys.argv[2]))
    host = importlib.import_module(f"benchmarks.hosts.{module}")
    try:
        finished = getattr(host, function)(job)
    except InputError as fault:
        print(fault, file=sys.stderr)
        return 1
    print(f"\n{MARK}{json.dumps(asdict(finished))}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
