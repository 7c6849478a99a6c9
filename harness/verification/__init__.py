"""Verifies an integrator of a user: adapters for functions, programs and engines, claims with bounds, exact states."""
