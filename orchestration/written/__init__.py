"""The files that people write: tables and their entries, quantities with units, expressions."""
