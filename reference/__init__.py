"""Exact motions at any precision."""
