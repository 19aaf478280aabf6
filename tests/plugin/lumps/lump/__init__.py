"""A lump of metal that cools."""
