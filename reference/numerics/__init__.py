"""Arithmetic and series that exact motions are computed with."""
