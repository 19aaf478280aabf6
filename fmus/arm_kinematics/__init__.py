"""Where an arm's tool point is, and how far its links' growth moves it."""
