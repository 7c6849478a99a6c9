"""Numerical stability: limits, resonances, round-off and robustness of every integrator, measured."""
