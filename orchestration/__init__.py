"""Everything that runs the components together, and what is learned from it."""
