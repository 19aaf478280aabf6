"""Models, gains and parameter sets of the laws, worked out from the plant's own equations."""
