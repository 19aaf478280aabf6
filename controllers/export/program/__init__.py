"""A law as a program without a language: run once with expressions, which become statements."""
