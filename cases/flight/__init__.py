"""Cases: points in uniform fields: projectiles, drag, charges, pulses."""
