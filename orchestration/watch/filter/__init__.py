"""The plant's filter in shadow: its states, what drives it, its noise and how likely readings are."""
