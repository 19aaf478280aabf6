"""What is made for use elsewhere: a law's C, a link of a solid, a page with a cell inside."""
