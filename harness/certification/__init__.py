"""Certificates of exact motions, and independent computations of the quantities of checks."""
