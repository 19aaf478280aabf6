"""The page that can be played with: a system, compiled for the browser, runs in it."""
