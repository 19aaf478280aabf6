"""Growth as a linear function of thermometers, fitted from a run."""
