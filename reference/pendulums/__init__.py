"""Exact motions. Pendulums: plane, spherical, on carts and springs, Foucault's."""
