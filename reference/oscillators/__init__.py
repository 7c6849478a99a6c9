"""Exact motions of oscillators: free, damped, forced, nonlinear, coupled."""
