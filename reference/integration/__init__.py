"""Integrations in high precision of equations without an exact motion: stiff ones, and motions of several modes."""
