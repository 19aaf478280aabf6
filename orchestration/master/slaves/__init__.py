"""Slaves: FMUs of any FMI version in this process, or each in a process of its own."""
