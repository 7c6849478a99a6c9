"""Exact motions. Oscillators: free, damped, forced, nonlinear, coupled."""
