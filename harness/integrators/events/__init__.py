"""Methods that locate events, and time stepping with contact."""
