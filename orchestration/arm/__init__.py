"""The six-axis arm: many heat sources, many links, one tool point."""
