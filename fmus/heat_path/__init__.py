"""Heat between two places of a machine, or from a source, that a model lacks."""
