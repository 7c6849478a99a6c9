"""Scenes, as a physics engine is given them, that several cases use, and long ones."""
