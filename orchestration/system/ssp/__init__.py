"""The formats of SSP: system structure, parameter values and mappings, and how their parts are resolved."""
