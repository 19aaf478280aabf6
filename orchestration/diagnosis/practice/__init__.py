"""Runs with a hidden effect, from other solvers or a machine's FMUs, for practice and for tests."""
