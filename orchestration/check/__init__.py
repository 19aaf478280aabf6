"""The checks that an integrator makes of an FMU, whoever made it, in a process of their own."""
