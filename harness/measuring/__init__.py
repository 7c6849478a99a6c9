"""Reference solutions at the samples, and the errors of an integrator's solution."""
