"""Exact motions of points in uniform fields: projectiles, drag, charges, pulses."""
