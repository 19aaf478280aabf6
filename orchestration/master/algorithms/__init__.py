"""Master algorithms, one in each file; their table; and what several of them share."""
