"""Native FMUs: C generated from the declaration beside hand-written C, compiled for each platform."""
