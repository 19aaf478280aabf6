"""What prints the figures of the READMEs: `python -m benchmarks.NAME` in the checkout; not installed."""

import os

# As the command does: see warmlink.orchestration.cli.main.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
