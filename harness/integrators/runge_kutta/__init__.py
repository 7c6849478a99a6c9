"""Explicit Runge-Kutta and Runge-Kutta-Nyström methods."""
