"""The master: it steps a system's slaves from communication point to communication point."""
