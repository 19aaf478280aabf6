"""A law as plain C for a controller: no heap, no input or output, no variables of its own."""
