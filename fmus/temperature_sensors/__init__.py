"""Thermometers between the true temperatures and whoever reads them."""
