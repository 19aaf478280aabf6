"""What follows from a verdict: the improvement, the next experiment, the extended model, the words."""
