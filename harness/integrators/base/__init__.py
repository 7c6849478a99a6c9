"""Code that families of integrators share: loops of steps, step-size control, error norm, linear systems."""
