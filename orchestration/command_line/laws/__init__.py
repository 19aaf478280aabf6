"""The commands that make a controller: its design, and its C."""
