"""From measured data to what the simulation gets wrong, why, and the extended model."""
