"""Right-hand sides as plain functions, numba and JAX call them."""
