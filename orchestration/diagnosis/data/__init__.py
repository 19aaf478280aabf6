"""Measured data: read, checked, thinned, and what is known of the experiment."""
