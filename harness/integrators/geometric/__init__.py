"""Splitting, Lie group, constrained and exponential methods."""
