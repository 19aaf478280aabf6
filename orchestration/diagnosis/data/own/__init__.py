"""Systems of FMUs that anybody made."""
