"""Exact motions. Points in uniform fields: projectiles, drag, charges, pulses."""
