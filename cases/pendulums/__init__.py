"""Cases: pendulums: plane, spherical, on carts and springs, Foucault's."""
