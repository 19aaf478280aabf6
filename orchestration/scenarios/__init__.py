"""Scenarios: which system, what drives it, what differs from nominal, and what is scored."""
