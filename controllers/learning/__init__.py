"""Laws learnt from measured logs, and what such a log says."""
