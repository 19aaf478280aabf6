"""Fits of sets of causes to data, the search for the best set, and the verdict."""
