"""Taylor series methods."""
