"""What is made for use elsewhere: FMUs and systems, a law's C, a link of a solid, a live page."""
