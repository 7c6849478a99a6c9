"""Scenes that several cases use, and long ones: what a physics engine is given."""
