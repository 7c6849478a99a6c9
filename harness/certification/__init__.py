"""Certificates of exact motions, and independent computations beside checks."""
