"""Heat that a model lacks, by an equation that somebody wrote or a diagnosis found."""
