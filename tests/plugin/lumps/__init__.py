"""A package of a stranger's, which adds a component, a law, a cause, a master algorithm and a command."""
