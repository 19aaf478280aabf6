"""A plain fit as an FMU: signals as linear functions of others, with memory of what these were."""
