"""Which pose an arm holds, one after another."""
