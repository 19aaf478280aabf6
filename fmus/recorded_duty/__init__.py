"""What a joint was recorded to do, row after row: a table of any length."""
