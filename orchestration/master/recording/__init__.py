"""What a run produces: recorded values, checkpoints, heat balances, its result."""
