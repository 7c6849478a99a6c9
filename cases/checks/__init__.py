"""Rows of the catalogue without motion."""
