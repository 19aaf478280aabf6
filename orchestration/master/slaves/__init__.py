"""Slaves: FMUs of FMI 2.0 and 3.0 in this process, or each in a process of its own."""
