"""Python FMUs: a slave for pythonfmu, with the modules that it needs under a name of their own."""
