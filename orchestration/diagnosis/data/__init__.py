"""Measured data: read, checked, thinned, and the system that it was measured on."""
