"""Exact motions in rotating frames: falls and tunnels on a rotating planet."""
