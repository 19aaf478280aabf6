"""Benchmarks: how long things take, side by side in one run."""
