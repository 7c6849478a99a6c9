"""Trajectories in files: read, mapped to the coordinates of a case, compared with its exact motion."""
