"""The twin beside a running machine: its filter in shadow, a sequential test, alarms and their causes."""
