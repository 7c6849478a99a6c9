"""FMUs as integrators: the archive, co-simulation and model exchange."""
