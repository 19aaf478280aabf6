"""Commands that run many scenarios: comparisons, sweeps, tuning."""
