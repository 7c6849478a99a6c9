"""Which integrators there are, by name, library and entry point."""
