"""The simulation of a measured run, with its derivatives by whatever may be wrong."""
