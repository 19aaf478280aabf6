"""The master algorithms that step a system's slaves from communication point to communication point."""
