"""A camera that sees, now and then, by how much the tool point is off."""
