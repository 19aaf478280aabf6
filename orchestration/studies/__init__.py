"""Comparisons, sweeps and tuning over many scenarios."""
