"""Adapters of third-party libraries as integrators; each file is named after its library."""
