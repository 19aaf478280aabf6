"""References that warmlink is compared with: the paper's tables and a 3-D finite-element model."""
