"""The registry of integrators, by name, library and entry point."""
