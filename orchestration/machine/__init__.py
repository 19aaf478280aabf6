"""A machine: its parts, wires, roles and nominal values, and what is made of them; shipped ones are data."""

DEFAULT = "WarmupCell"
"""Machine of whatever names none: one motor, one link."""
