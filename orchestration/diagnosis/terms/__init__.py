"""What no cause explains becomes an equation: missing heat, candidate terms, and what is believed."""
