"""What an integrator implements and is given."""
