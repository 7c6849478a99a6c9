"""Explicit Runge-Kutta and Runge-Kutta-Nystroem methods."""
