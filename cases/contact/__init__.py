"""Cases: friction, impact and loss of contact."""
