"""Multistep and extrapolation methods."""
