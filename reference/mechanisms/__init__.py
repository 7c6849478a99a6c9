"""Exact motions of closed chains of rigid bodies."""
