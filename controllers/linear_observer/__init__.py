"""A Kalman filter on a linear model of any machine, which was found from runs of its FMUs."""
