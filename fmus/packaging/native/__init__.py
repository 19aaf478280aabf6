"""Hand-written C of the native FMUs: what every component shares, and one file an FMI version."""
