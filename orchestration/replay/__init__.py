"""Laws learnt from measured logs, and judged on them, without a plant."""
