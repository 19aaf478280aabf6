"""The expression of the paper for the growth of a link whose base is held at a temperature."""
