"""Master algorithms, one a file, their table, and what several of them share."""
