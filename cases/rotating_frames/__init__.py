"""Cases: falls and tunnels in the frame of a turning planet."""
