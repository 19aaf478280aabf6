"""A component becomes an FMU: its description and documentation, its Python and native forms."""
