"""Scenes as files that other programs read, each with the exact motion beside it."""
