"""Commands on what is published."""
