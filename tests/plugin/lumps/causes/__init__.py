"""Causes of a stranger's."""
