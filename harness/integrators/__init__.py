"""In-house integrators, one folder for each kind of method, one file for each family."""
