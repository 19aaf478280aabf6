"""The plant, its instruments, and how a declared component becomes an FMU."""
