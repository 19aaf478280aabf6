"""The arguments and options of each command, and the call that each makes."""
