"""Exact motions. Friction, impact and loss of contact."""
