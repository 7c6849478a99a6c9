"""Verifies integrators of others: doors through which they come in, claims with bounds, exact states to compare with."""
