"""The six-axis arm measured as a whole: an experiment, a diagnosis and hidden effects for each axis."""
