"""An electric heater on a link."""
