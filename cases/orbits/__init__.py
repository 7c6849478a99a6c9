"""Cases: motions about a centre of force, and of two and three bodies."""
