"""Scenario files, their loader and the metrics of a closed-loop run."""
