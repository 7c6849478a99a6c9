"""In-house integrators, one family a file."""
