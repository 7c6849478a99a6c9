"""Implicit Runge-Kutta methods: Gauss and Radau."""
