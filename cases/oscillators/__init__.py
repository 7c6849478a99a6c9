"""Cases: oscillators: free, damped, forced, nonlinear, coupled."""
