"""What the simulation gets wrong, why, what to add to the model, and how much that gains."""
