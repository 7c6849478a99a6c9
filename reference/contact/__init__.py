"""Exact motions with friction, impact and loss of contact."""
