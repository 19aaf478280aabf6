"""Growth that follows the losses of the motor with one time constant."""
