"""A case's equations: traced, generated as source text, compiled; machine code kept on disk."""
