"""An exported law on the processor of a machine's controller, in the closed loop."""
