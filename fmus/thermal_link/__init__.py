"""A slender link that conducts, loses and stores heat, and grows."""
