"""A law in a controller's own language: C with no heap, no input or output, no variables of its own."""
