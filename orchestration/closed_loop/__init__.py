"""A scenario of any system found by name, run with a controller and without one, and judged."""
