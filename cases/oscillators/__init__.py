"""Cases. Oscillators: free, damped, forced, nonlinear, coupled."""
