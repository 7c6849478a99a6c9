"""Exact motions. Falls and tunnels in the frame of a turning planet."""
