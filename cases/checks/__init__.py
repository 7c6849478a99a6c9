"""Checks: rows of the catalogue without motion."""
