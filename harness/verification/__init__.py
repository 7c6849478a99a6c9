"""Verifies integrators of others: doors through which they come in, claims with derived bounds, exact states to compare with."""
