"""Verifies an outsider's integrator: doors for what a user brings, claims with derived bounds, and their report."""
