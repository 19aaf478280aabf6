"""What a run leaves: recorded values, checkpoints, heat balances, its result."""
