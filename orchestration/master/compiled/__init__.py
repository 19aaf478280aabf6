"""The loop over communication points, compiled."""
