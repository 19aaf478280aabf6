"""References that warmlink is compared with: the paper's tables, by 3-D finite elements too."""
