"""Exact motions. Central forces, two and three bodies."""
