"""Adapters of third-party libraries as integrators; each file is named after its library, those of engines in `engines`."""
