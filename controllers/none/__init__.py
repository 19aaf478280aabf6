"""No compensation: what every other law is measured against."""
