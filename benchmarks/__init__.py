"""What prints the figures of the READMEs: `python -m benchmarks.NAME` in the checkout; not installed."""
