"""A Kalman filter on the reduced model of motor and link."""
