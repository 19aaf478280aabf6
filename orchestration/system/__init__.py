"""Systems of components: read from SSP, checked, written to SSP."""
