"""From one declaration to an FMU: integration, model description, Python and native forms."""
