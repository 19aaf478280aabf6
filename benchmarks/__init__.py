"""What prints the figures of the READMEs: `python -m benchmarks.NAME` in the checkout; not installed."""

from warmlink.orchestration.threads import one_thread_from_the_start

one_thread_from_the_start()
