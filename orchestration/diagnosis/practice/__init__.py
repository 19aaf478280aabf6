"""Runs with a hidden effect, from other solvers, for practice and for tests."""
