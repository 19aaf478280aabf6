"""What the cell is asked to do, segment after segment."""
