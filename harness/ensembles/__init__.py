"""Distributions of the error over many starts: draws, exact states, integration in blocks, counts."""
