"""The controllers that take a link's thermal growth out of the tool point."""
