"""Files as loggers and spreadsheets write them: columns of cells, their units, times and numbers."""
