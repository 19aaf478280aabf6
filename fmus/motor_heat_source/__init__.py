"""A motor's winding and shaft, the heat they make, and where it goes."""
