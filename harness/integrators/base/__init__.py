"""Shared by several families of integrators: loops of steps, step-size control, error norm, linear systems."""
