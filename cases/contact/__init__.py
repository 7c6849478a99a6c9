"""Cases. Friction, impact and loss of contact."""
