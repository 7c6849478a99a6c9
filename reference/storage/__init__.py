"""The cache of results on disk."""
