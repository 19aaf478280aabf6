"""References that warmlink is held against: the paper's tables and a 3-D finite-element model."""
