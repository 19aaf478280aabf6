"""A link of any shape, reduced from finite elements: its matrices are data."""
