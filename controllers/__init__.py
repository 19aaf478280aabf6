"""The controllers that compensate the thermal growth of a link at the tool point."""
