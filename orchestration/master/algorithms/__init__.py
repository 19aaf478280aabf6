"""Master algorithms: explicit, iterated, in parts of a step; their table; and what they share."""
