"""Verifies integrators of others: adapters through which they come in, claims with bounds, exact states to compare with."""
