"""Growth in proportion to the temperature at the tip."""
